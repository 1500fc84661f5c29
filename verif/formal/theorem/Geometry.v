(* The contract (docs/theory.md, sections 1 and 2) over the real numbers: triangles as hulls of any three
   vertices, the Chebyshev distance, and what it means that a vector separates two triangles. *)

From Coq Require Export Reals Lra List.
Export ListNotations.
Open Scope R_scope.

Record vector := Vector { x : R; y : R; z : R }.

Definition zero := Vector 0 0 0.
Definition add u v := Vector (x u + x v) (y u + y v) (z u + z v).
Definition minus u v := Vector (x u - x v) (y u - y v) (z u - z v).
Definition scale k v := Vector (k * x v) (k * y v) (k * z v).
Definition inner u v := x u * x v + y u * y v + z u * z v.
Definition cross u v :=
  Vector (y u * z v - z u * y v) (z u * x v - x u * z v) (x u * y v - y u * x v).

Definition norm1 v := Rabs (x v) + Rabs (y v) + Rabs (z v).
Definition chebyshev u v := Rmax (Rabs (x u - x v)) (Rmax (Rabs (y u - y v)) (Rabs (z u - z v))).

Inductive three := First | Second | Third.

Definition next i := match i with First => Second | Second => Third | Third => First end.
Definition total (f : three -> R) := f First + f Second + f Third.

(* The vertices need not differ: segments and points are triangles too. *)
Definition triangle := three -> vector.

Definition weighted (w : three -> R) (T : triangle) :=
  Vector (total (fun i => w i * x (T i))) (total (fun i => w i * y (T i))) (total (fun i => w i * z (T i))).

Definition holds (T : triangle) p :=
  exists w, (forall i, 0 <= w i) /\ total w = 1 /\ p = weighted w T.

Definition is_distance A B d :=
  (exists p q, holds A p /\ holds B q /\ chebyshev p q = d) /\
  (forall p q, holds A p -> holds B q -> d <= chebyshev p q).

Definition near A B m := exists p q, holds A p /\ holds B q /\ chebyshev p q <= m.

(* min(c.B) - max(c.A) > m |c|1, said of each vertex of the one and of the other. *)
Definition ahead c (A B : triangle) m := forall i j, inner c (B j) - inner c (A i) > m * norm1 c.

Definition separates c (A B : triangle) m := ahead c A B m \/ ahead c B A m.

Lemma vector_equal u v : x u = x v -> y u = y v -> z u = z v -> u = v.
Proof. destruct u, v; simpl; congruence. Qed.

Ltac by_coordinates := apply vector_equal; unfold weighted, total, add, minus, scale, cross, zero; simpl.

Lemma norm1_is_positive v : 0 <= norm1 v.
Proof. unfold norm1. pose proof (Rabs_pos (x v)); pose proof (Rabs_pos (y v)); pose proof (Rabs_pos (z v)). lra. Qed.

Lemma norm1_of_zero_alone v : norm1 v = 0 -> v = zero.
Proof.
  unfold norm1. intro S.
  pose proof (Rabs_pos (x v)); pose proof (Rabs_pos (y v)); pose proof (Rabs_pos (z v)).
  assert (root : forall a, Rabs a = 0 -> a = 0)
    by (intros a E; destruct (Req_EM_T a 0) as [|N]; [assumption | exfalso; exact (Rabs_no_R0 a N E)]).
  apply vector_equal; apply root; lra.
Qed.

Lemma chebyshev_at_most u v m :
  chebyshev u v <= m <->
  Rabs (x u - x v) <= m /\ Rabs (y u - y v) <= m /\ Rabs (z u - z v) <= m.
Proof.
  unfold chebyshev. split.
  - intro H. repeat split; refine (Rle_trans _ _ _ _ H);
      unfold Rmax; repeat destruct Rle_dec; lra.
  - intros (Hx & Hy & Hz). repeat apply Rmax_lub; assumption.
Qed.

Lemma inner_weighted c w T : inner c (weighted w T) = total (fun i => w i * inner c (T i)).
Proof. unfold inner, weighted, total; simpl; ring. Qed.

(* Weighted by what adds up to t, numbers of at most k come to at most t k. *)
Lemma total_at_most w f k t :
  (forall i, 0 <= w i) -> total w = t -> (forall i, f i <= k) -> total (fun i => w i * f i) <= t * k.
Proof.
  unfold total. intros Hw Ht Hf.
  pose proof (fun i => Rmult_le_compat_l (w i) (f i) k (Hw i) (Hf i)) as H.
  pose proof (H First); pose proof (H Second); pose proof (H Third). subst t. lra.
Qed.

Lemma total_at_least w f k t :
  (forall i, 0 <= w i) -> total w = t -> (forall i, k <= f i) -> t * k <= total (fun i => w i * f i).
Proof.
  unfold total. intros Hw Ht Hf.
  pose proof (fun i => Rmult_le_compat_l (w i) k (f i) (Hw i) (Hf i)) as H.
  pose proof (H First); pose proof (H Second); pose proof (H Third). subst t. lra.
Qed.

(* |c.v| is at most |c|1 times the largest coordinate of v. *)
Lemma inner_at_most c u v m : chebyshev u v <= m -> inner c v - inner c u <= m * norm1 c.
Proof.
  intro H. apply chebyshev_at_most in H. destruct H as (Hx & Hy & Hz).
  assert (part : forall a b d, Rabs (b - d) <= m -> a * d - a * b <= m * Rabs a).
  { intros a b d Hd. apply Rle_trans with (Rabs (a * (d - b))).
    - pose proof (Rle_abs (a * (d - b))). lra.
    - rewrite Rabs_mult, (Rabs_minus_sym d b), Rmult_comm.
      apply Rmult_le_compat_r; [apply Rabs_pos | exact Hd]. }
  unfold inner, norm1.
  pose proof (part (x c) _ _ Hx); pose proof (part (y c) _ _ Hy); pose proof (part (z c) _ _ Hz). lra.
Qed.

(* The largest of a list, by the values of a function. *)
Lemma extreme {T} (f : T -> R) l : l = [] \/ exists a, In a l /\ forall b, In b l -> f b <= f a.
Proof.
  induction l as [|a l IH]; [auto|]. right. destruct IH as [-> | (c & Hc & Mc)].
  - exists a. split; [simpl; auto|]. intros b [<-|[]]. lra.
  - destruct (Rle_dec (f a) (f c)); [exists c | exists a]; (split; [simpl; auto|]);
      intros b [<-|Hb]; try specialize (Mc b Hb); lra.
Qed.

Definition threes := [First; Second; Third].

Lemma in_threes i : In i threes.
Proof. destruct i; simpl; auto. Qed.

Lemma largest (f : three -> R) : exists i, forall j, f j <= f i.
Proof. destruct (extreme f threes) as [E | (i & _ & M)]; [discriminate E | eauto using in_threes]. Qed.

Lemma ahead_is_not_near c A B m : ahead c A B m -> ~ near A B m.
Proof.
  intros far (p & q & (w & Hw & Sw & ->) & (v & Hv & Sv & ->) & H).
  apply (inner_at_most c) in H. rewrite !inner_weighted in H.
  destruct (largest (fun i => inner c (A i))) as [i Hi].
  destruct (largest (fun j => - inner c (B j))) as [j Hj].
  pose proof (far i j).
  pose proof (total_at_most w _ _ 1 Hw Sw Hi).
  assert (Hj' : forall k, inner c (B j) <= inner c (B k)) by (intro k; specialize (Hj k); lra).
  pose proof (total_at_least v _ _ 1 Hv Sv Hj'). lra.
Qed.

Lemma near_symmetric A B m : near A B m -> near B A m.
Proof.
  intros (p & q & Hp & Hq & H). exists q, p. repeat split; try assumption.
  apply chebyshev_at_most in H. apply chebyshev_at_most.
  rewrite (Rabs_minus_sym (x q)), (Rabs_minus_sym (y q)), (Rabs_minus_sym (z q)). exact H.
Qed.

(* The easy half: no vector whatever separates what is near. *)
Theorem separated_is_not_near c A B m : separates c A B m -> ~ near A B m.
Proof.
  intros [H | H] N.
  - exact (ahead_is_not_near c A B m H N).
  - exact (ahead_is_not_near c B A m H (near_symmetric _ _ _ N)).
Qed.
