(* What is not near, some vector separates (docs/theory.md, section 3). Instead of the nearest point of a
   compact set: elimination of the coordinates one by one, as Fourier and Motzkin do it. *)

From Triaxis Require Import Geometry.

(* A set of vectors that sums and positive multiples do not leave. *)
Record cone (K : vector -> Prop) := {
  cone_add : forall u v, K u -> K v -> K (add u v);
  cone_scale : forall k v, 0 < k -> K v -> K (scale k v) }.

Definition all_positive c P := forall p, In p P -> 0 < inner c p.

Lemma between (L U : list R) :
  (forall l u, In l L -> In u U -> l < u) ->
  exists t, (forall l, In l L -> l < t) /\ (forall u, In u U -> t < u).
Proof.
  intro H. destruct (extreme (fun l => l) L) as [-> | (l & Hl & Ml)], (extreme Ropp U) as [-> | (u & Hu & Mu)];
    [exists 0 | exists (u - 1) | exists (l + 1) | exists ((l + u) / 2); specialize (H l u Hl Hu)];
    (split; intros k K; [try specialize (Ml k K) | try specialize (Mu k K)]; try destruct K); lra.
Qed.

Section Elimination.

Variables (K : vector -> Prop) (e : vector).
Hypothesis K_cone : cone K.

(* The positive multiples of a vector before the plane across e and of one behind it, added so that the sum
   is in the plane. *)
Definition meet p n := add (scale (- inner e n) p) (scale (inner e p) n).

Definition before := filter (fun p => if Rlt_dec 0 (inner e p) then true else false).
Definition behind := filter (fun p => if Rlt_dec (inner e p) 0 then true else false).
Definition within := filter (fun p => if Req_EM_T (inner e p) 0 then true else false).

Definition eliminated P :=
  within P ++ flat_map (fun p => map (meet p) (behind P)) (before P).

Lemma in_before p P : In p (before P) <-> In p P /\ 0 < inner e p.
Proof. unfold before. rewrite filter_In. destruct Rlt_dec; intuition congruence. Qed.

Lemma in_behind p P : In p (behind P) <-> In p P /\ inner e p < 0.
Proof. unfold behind. rewrite filter_In. destruct Rlt_dec; intuition congruence. Qed.

Lemma in_within p P : In p (within P) <-> In p P /\ inner e p = 0.
Proof. unfold within. rewrite filter_In. destruct Req_EM_T; intuition congruence. Qed.

Lemma inner_meet c p n : inner c (meet p n) = - inner e n * inner c p + inner e p * inner c n.
Proof. unfold meet, inner, add, scale; simpl; ring. Qed.

Lemma in_eliminated v P :
  In v (eliminated P) <->
  (In v P /\ inner e v = 0) \/
  (exists p n, In p P /\ 0 < inner e p /\ In n P /\ inner e n < 0 /\ v = meet p n).
Proof.
  unfold eliminated. rewrite in_app_iff, in_within, in_flat_map. split.
  - intros [H | (p & Hp & Hm)]; [left; exact H|]. right.
    apply in_map_iff in Hm. destruct Hm as (n & <- & Hn).
    apply in_before in Hp. apply in_behind in Hn. exists p, n. tauto.
  - intros [H | (p & n & Hp & Sp & Hn & Sn & ->)]; [left; exact H|]. right.
    exists p. split; [apply in_before; tauto|]. apply in_map, in_behind. tauto.
Qed.

Lemma eliminated_in_plane P v : In v (eliminated P) -> inner e v = 0.
Proof.
  rewrite in_eliminated. intros [[_ H] | (p & n & _ & _ & _ & _ & ->)]; [exact H|].
  rewrite inner_meet. ring.
Qed.

Lemma eliminated_in_cone P : (forall p, In p P -> K p) -> forall v, In v (eliminated P) -> K v.
Proof.
  intros H v Hv. apply in_eliminated in Hv.
  destruct Hv as [[Hv _] | (p & n & Hp & Sp & Hn & Sn & ->)]; [auto|].
  apply (cone_add K K_cone); apply (cone_scale K K_cone); auto; lra.
Qed.

Lemma eliminated_keeps_plane P f :
  (forall p, In p P -> inner f p = 0) -> forall v, In v (eliminated P) -> inner f v = 0.
Proof.
  intros H v Hv. apply in_eliminated in Hv.
  destruct Hv as [[Hv _] | (p & n & Hp & _ & Hn & _ & ->)]; [auto|].
  rewrite inner_meet, (H p Hp), (H n Hn). ring.
Qed.

(* c works for what is eliminated: c + t e, for some t, works for all. *)
Lemma lift P : (exists c, all_positive c (eliminated P)) -> exists c, all_positive c P.
Proof.
  intros [c Hc].
  destruct (between (map (fun p => - inner c p / inner e p) (before P))
                    (map (fun n => - inner c n / inner e n) (behind P))) as [t [HL HU]].
  { intros l u Hl Hu. apply in_map_iff in Hl. apply in_map_iff in Hu.
    destruct Hl as (p & <- & Hp), Hu as (n & <- & Hn).
    apply in_before in Hp. apply in_behind in Hn.
    assert (0 < inner c (meet p n)) as H.
    { apply Hc, in_eliminated. right. exists p, n. tauto. }
    rewrite inner_meet in H. destruct Hp as [_ Sp], Hn as [_ Sn].
    apply Rmult_lt_reg_r with (inner e p * - inner e n).
    - apply Rmult_lt_0_compat; lra.
    - replace (- inner c p / inner e p * (inner e p * - inner e n)) with (inner c p * inner e n)
        by (field; lra).
      replace (- inner c n / inner e n * (inner e p * - inner e n)) with (inner c n * inner e p)
        by (field; lra).
      lra. }
  exists (add c (scale t e)). intros p Hp.
  assert (E : inner (add c (scale t e)) p = inner c p + t * inner e p)
    by (unfold inner, add, scale; simpl; ring).
  rewrite E. destruct (Rtotal_order (inner e p) 0) as [S | [S | S]].
  - assert (H : t < - inner c p / inner e p).
    { apply HU, in_map_iff. exists p. split; [reflexivity | apply in_behind; tauto]. }
    apply (Rmult_lt_compat_l (- inner e p)) in H; [|lra].
    replace (- inner e p * (- inner c p / inner e p)) with (inner c p) in H by (field; lra). lra.
  - assert (0 < inner c p) by (apply Hc, in_eliminated; left; tauto). rewrite S. lra.
  - assert (H : - inner c p / inner e p < t).
    { apply HL, in_map_iff. exists p. split; [reflexivity | apply in_before; tauto]. }
    apply (Rmult_lt_compat_l (inner e p)) in H; [|lra].
    replace (inner e p * (- inner c p / inner e p)) with (- inner c p) in H by (field; lra). lra.
Qed.

End Elimination.

Definition ex := Vector 1 0 0.
Definition ey := Vector 0 1 0.
Definition ez := Vector 0 0 1.

(* Gordan: a finite set of vectors lies strictly on one side of a plane through 0, or 0 is in every cone that
   holds it. *)
Theorem one_side_or_zero K P :
  cone K -> (forall p, In p P -> K p) -> (exists c, all_positive c P) \/ K zero.
Proof.
  intros HK HP.
  set (P1 := eliminated ex P). set (P2 := eliminated ey P1). set (P3 := eliminated ez P2).
  assert (zeros : forall v, In v P3 -> v = zero).
  { intros v Hv.
    assert (Hz : inner ez v = 0) by exact (eliminated_in_plane _ _ _ Hv).
    assert (Hy : inner ey v = 0).
    { refine (eliminated_keeps_plane ez P2 ey _ v Hv). apply eliminated_in_plane. }
    assert (Hx : inner ex v = 0).
    { refine (eliminated_keeps_plane ez P2 ex _ v Hv).
      refine (eliminated_keeps_plane ey P1 ex _). apply eliminated_in_plane. }
    unfold inner, ex, ey, ez in *; simpl in *. apply vector_equal; simpl; lra. }
  assert (K3 : forall v, In v P3 -> K v).
  { unfold P3, P2, P1. repeat apply eliminated_in_cone; assumption. }
  assert (first : P3 = [] \/ exists v, In v P3) by (destruct P3 as [|v l]; simpl; eauto).
  destruct first as [none | [v Hv]].
  - left. apply (lift ex P), (lift ey P1), (lift ez P2).
    exists zero. fold P3. rewrite none. intros ? [].
  - right. rewrite <- (zeros v Hv). apply K3, Hv.
Qed.

Section Triangles.

Variables (A B : triangle) (m : R).
Hypothesis m_positive : 0 <= m.

(* Positive multiples of what reaches from a point of A to within m of a point of B. *)
Definition reach v :=
  exists t a b, 0 < t /\ (forall i, 0 <= a i) /\ (forall i, 0 <= b i) /\ total a = t /\ total b = t /\
  let d := minus v (minus (weighted b B) (weighted a A)) in
  Rabs (x d) <= t * m /\ Rabs (y d) <= t * m /\ Rabs (z d) <= t * m.

Lemma sum_within a b t s c : Rabs a <= t * m -> Rabs b <= s * m -> c = a + b -> Rabs c <= (t + s) * m.
Proof. intros. subst c. pose proof (Rabs_triang a b). lra. Qed.

Lemma reach_is_cone : cone reach.
Proof.
  split.
  - intros u v (t & a & b & Ht & Ha & Hb & Sa & Sb & Hx & Hy & Hz)
               (s & f & g & Hs & Hf & Hg & Sf & Sg & Gx & Gy & Gz).
    exists (t + s), (fun i => a i + f i), (fun i => b i + g i).
    split; [lra|]. split; [intro i; specialize (Ha i); specialize (Hf i); lra|].
    split; [intro i; specialize (Hb i); specialize (Hg i); lra|].
    split; [rewrite <- Sa, <- Sf; unfold total; ring|]. split; [rewrite <- Sb, <- Sg; unfold total; ring|].
    unfold weighted, total in *; simpl in *.
    split; [|split]; [apply (sum_within _ _ _ _ _ Hx Gx) | apply (sum_within _ _ _ _ _ Hy Gy)
                     | apply (sum_within _ _ _ _ _ Hz Gz)]; ring.
  - intros k v Hk (t & a & b & Ht & Ha & Hb & Sa & Sb & Hx & Hy & Hz).
    exists (k * t), (fun i => k * a i), (fun i => k * b i).
    assert (scaled : forall d g, Rabs d <= t * m -> g = k * d -> Rabs g <= k * t * m).
    { intros d g Hd ->. rewrite Rabs_mult, (Rabs_pos_eq k), Rmult_assoc by lra.
      apply Rmult_le_compat_l; lra. }
    split; [apply Rmult_lt_0_compat; assumption|]. split; [intro i; apply Rmult_le_pos; [lra | auto]|].
    split; [intro i; apply Rmult_le_pos; [lra | auto]|].
    split; [rewrite <- Sa; unfold total; ring|]. split; [rewrite <- Sb; unfold total; ring|].
    unfold weighted, total in *; simpl in *.
    split; [|split]; [apply (scaled _ _ Hx) | apply (scaled _ _ Hy) | apply (scaled _ _ Hz)]; ring.
Qed.

Definition corners :=
  [Vector m m m; Vector m m (-m); Vector m (-m) m; Vector m (-m) (-m);
   Vector (-m) m m; Vector (-m) m (-m); Vector (-m) (-m) m; Vector (-m) (-m) (-m)].

Definition reached :=
  flat_map (fun i => flat_map (fun j => map (add (minus (B j) (A i))) corners) threes) threes.

Lemma in_reached i j s : In s corners -> In (add (minus (B j) (A i)) s) reached.
Proof.
  intro H. apply in_flat_map. exists i. split; [apply in_threes|].
  apply in_flat_map. exists j. split; [apply in_threes|]. apply in_map, H.
Qed.

Definition only (i j : three) :=
  match i, j with First, First | Second, Second | Third, Third => 1 | _, _ => 0 end.

Lemma only_total i : total (only i) = 1.
Proof. unfold total. destruct i; simpl; ring. Qed.

Lemma only_positive i j : 0 <= only i j.
Proof. destruct i, j; simpl; lra. Qed.

Lemma only_weighted i T : weighted (only i) T = T i.
Proof. destruct i; by_coordinates; ring. Qed.

Lemma reached_is_in_reach v : In v reached -> reach v.
Proof.
  intro H. apply in_flat_map in H. destruct H as (i & _ & H).
  apply in_flat_map in H. destruct H as (j & _ & H).
  apply in_map_iff in H. destruct H as (s & <- & H).
  exists 1, (only i), (only j). rewrite !only_total, !only_weighted.
  assert (E : minus (add (minus (B j) (A i)) s) (minus (B j) (A i)) = s)
    by (by_coordinates; ring).
  repeat split; try lra; try (intro; apply only_positive); cbv zeta; rewrite E;
    repeat (destruct H as [<-|H]; [simpl; rewrite ?Rabs_Ropp, Rabs_pos_eq; lra|]); destruct H.
Qed.

Lemma reach_of_zero : reach zero -> near A B m.
Proof.
  intros (t & a & b & Ht & Ha & Hb & Sa & Sb & Hx & Hy & Hz).
  exists (weighted (fun i => a i / t) A), (weighted (fun i => b i / t) B).
  assert (part : forall w : three -> R, (forall i, 0 <= w i) -> forall i, 0 <= w i / t).
  { intros w Hw i. apply Rmult_le_pos; [auto | left; apply Rinv_0_lt_compat, Ht]. }
  assert (scaled : forall d g, Rabs d <= t * m -> g = d / t -> Rabs g <= m).
  { intros d g Hd ->. unfold Rdiv. rewrite Rabs_mult, Rabs_inv, (Rabs_pos_eq t) by lra.
    apply Rmult_le_reg_r with t; [exact Ht|]. rewrite Rmult_assoc, Rinv_l; lra. }
  split; [|split].
  - eexists. split; [exact (part a Ha)|]. split; [|reflexivity].
    unfold total in *. rewrite <- Sa in *. field. lra.
  - eexists. split; [exact (part b Hb)|]. split; [|reflexivity].
    unfold total in *. rewrite <- Sb in *. field. lra.
  - apply chebyshev_at_most. unfold weighted, total in *; simpl in *.
    split; [|split]; [apply (scaled _ _ Hx) | apply (scaled _ _ Hy) | apply (scaled _ _ Hz)]; field; lra.
Qed.

Definition signed c := if Rle_dec 0 c then - m else m.

Lemma signed_product c : c * signed c = - m * Rabs c.
Proof.
  unfold signed. destruct Rle_dec; [rewrite Rabs_pos_eq | rewrite Rabs_left1]; lra.
Qed.

Lemma one_side_is_ahead c : all_positive c reached -> ahead c A B m.
Proof.
  intros H i j.
  set (s := Vector (signed (x c)) (signed (y c)) (signed (z c))).
  assert (Hs : In s corners).
  { unfold s, signed. repeat destruct Rle_dec; simpl; tauto. }
  specialize (H _ (in_reached i j s Hs)).
  assert (E : inner c (add (minus (B j) (A i)) s) = inner c (B j) - inner c (A i) - m * norm1 c).
  { unfold inner, add, minus, s, norm1; simpl.
    pose proof (signed_product (x c)); pose proof (signed_product (y c)); pose proof (signed_product (z c)).
    lra. }
  lra.
Qed.

Theorem near_or_some_vector_separates : near A B m \/ exists c, ahead c A B m.
Proof.
  destruct (one_side_or_zero reach reached reach_is_cone reached_is_in_reach) as [[c H] | H].
  - right. exists c. apply one_side_is_ahead, H.
  - left. apply reach_of_zero, H.
Qed.

End Triangles.
