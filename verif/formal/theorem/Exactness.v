(* The theorem of docs/theory.md, section 2, for the list of axes that the golden package defines and that the
   proofs of the RTL compare the core with: Axes.v is made from it. *)

From Triaxis Require Import Geometry Separation Descent Axes.

Definition index i := match i with First => 0%nat | Second => 1%nat | Third => 2%nat end.

(* The number of the axis that a product of two planes' vectors is, up to its sign. *)
Definition number p q :=
  (match p, q with
   | EdgeA _, EdgeA _ => 3
   | EdgeB _, EdgeB _ => 4
   | Unit i, Unit j => 3 - index i - index j
   | EdgeA i, EdgeB j | EdgeB j, EdgeA i => 5 + 3 * index i + index j
   | EdgeA i, Unit k | Unit k, EdgeA i => 14 + 3 * index i + index k
   | EdgeB j, Unit k | Unit k, EdgeB j => 23 + 3 * index j + index k
   end)%nat.

Theorem there_are_32 A B : length (axes A B) = 32%nat.
Proof. reflexivity. Qed.

Lemma product_is_an_axis A B p q :
  let product := cross (across A B p) (across A B q) in
  let axis := nth (number p q) (axes A B) zero in
  product = zero \/ product = axis \/ product = scale (-1) axis.
Proof.
  destruct p as [[]|[]|[]], q as [[]|[]|[]];
    cbn [number index Nat.add Nat.mul Nat.sub nth axes across edge unit next];
    first [ left; by_coordinates; unfold edge, minus, ex, ey, ez; simpl; ring
          | right; left; by_coordinates; unfold edge, minus, ex, ey, ez; simpl; ring
          | right; right; by_coordinates; unfold edge, minus, ex, ey, ez; simpl; ring ].
Qed.

Lemma number_is_listed p q : (number p q < 32)%nat.
Proof. destruct p as [[]|[]|[]], q as [[]|[]|[]]; cbv; repeat constructor. Qed.

Lemma zero_separates_nothing A B m : ~ separates zero A B m.
Proof.
  intros [H | H]; specialize (H First First); unfold inner, norm1, zero in H; simpl in H;
    rewrite Rabs_R0 in H; lra.
Qed.

Definition some_axis_separates A B m := exists c, In c (axes A B) /\ separates c A B m.

Theorem near_exactly A B m : 0 <= m -> near A B m <-> ~ some_axis_separates A B m.
Proof.
  intro M. split.
  - intros N (c & _ & S). exact (separated_is_not_near c A B m S N).
  - intro H. destruct (near_or_some_vector_separates A B m M) as [N | [c S]]; [exact N|].
    exfalso. apply H. destruct (some_cross_product_separates A B m c S) as (p & q & P).
    exists (nth (number p q) (axes A B) zero). split.
    + apply nth_In. rewrite there_are_32. apply number_is_listed.
    + destruct (product_is_an_axis A B p q) as [E | [E | E]]; rewrite E in P.
      * exfalso. exact (zero_separates_nothing A B m P).
      * exact P.
      * apply separates_backwards, P.
Qed.

(* The distance, a least one of all pairs of points, exists: so "clear" is what remains. *)

Lemma gap c S T : exists g, forall m, ahead c S T m <-> m * norm1 c < g.
Proof.
  destruct (largest (fun i => inner c (S i))) as [i Hi].
  destruct (largest (fun j => - inner c (T j))) as [j Hj].
  exists (inner c (T j) - inner c (S i)). intro m. split; intro H; [exact (H i j)|].
  intros k l. specialize (Hi k). specialize (Hj l). simpl in *. lra.
Qed.

Lemma separates_or_not A B m c : separates c A B m \/ ~ separates c A B m.
Proof.
  unfold separates. destruct (gap c A B) as [g Hg], (gap c B A) as [h Hh]. rewrite Hg, Hh.
  destruct (Rlt_dec (m * norm1 c) g), (Rlt_dec (m * norm1 c) h); tauto.
Qed.

Lemma some_axis_or_none A B m : some_axis_separates A B m \/ ~ some_axis_separates A B m.
Proof.
  unfold some_axis_separates. induction (axes A B) as [|c l IH]; [right; intros (? & [] & _)|].
  destruct (separates_or_not A B m c) as [S | S]; [left; exists c; simpl; auto|].
  destruct IH as [(d & I & D) | N]; [left; exists d; simpl; auto|].
  right. intros (d & [<-|I] & D); [contradiction | eauto].
Qed.

Lemma one_axis_bounds c A B :
  exists d, 0 <= d /\ forall m, 0 <= m -> (~ separates c A B m <-> d <= m).
Proof.
  destruct (gap c A B) as [g Hg], (gap c B A) as [h Hh].
  destruct (Req_EM_T (norm1 c) 0) as [Z | P].
  - exists 0. split; [lra|]. intros m M. split; [intros _; exact M|]. intros _.
    rewrite (norm1_of_zero_alone c Z). apply zero_separates_nothing.
  - pose proof (norm1_is_positive c) as Q.
    exists (Rmax 0 (Rmax (g / norm1 c) (h / norm1 c))). split; [apply Rmax_l|]. intros m M.
    assert (moved : forall k, k / norm1 c <= m <-> ~ m * norm1 c < k).
    { intro k. assert (E : k = k / norm1 c * norm1 c) by (field; exact P). split; intro H.
      - apply (Rmult_le_compat_r (norm1 c)) in H; lra.
      - apply Rmult_le_reg_r with (norm1 c); lra. }
    unfold separates. rewrite Hg, Hh. split; intro H.
    + repeat apply Rmax_lub; [exact M | apply moved; tauto | apply moved; tauto].
    + pose proof (Rmax_l 0 (Rmax (g / norm1 c) (h / norm1 c))).
      pose proof (Rmax_r 0 (Rmax (g / norm1 c) (h / norm1 c))).
      pose proof (Rmax_l (g / norm1 c) (h / norm1 c)); pose proof (Rmax_r (g / norm1 c) (h / norm1 c)).
      intros [S | S]; revert S; apply moved; lra.
Qed.

Lemma all_axes_bound A B :
  exists d, 0 <= d /\ forall m, 0 <= m -> (~ some_axis_separates A B m <-> d <= m).
Proof.
  assert (H : forall l, exists d, 0 <= d /\
              forall m, 0 <= m -> ((~ exists c, In c l /\ separates c A B m) <-> d <= m)).
  { induction l as [|c l (d & D & H)].
    - exists 0. split; [lra|]. intros m M. split; [intros _; exact M|]. intros _ (c & [] & _).
    - destruct (one_axis_bounds c A B) as (b & P & G).
      exists (Rmax b d). split; [pose proof (Rmax_l b d); lra|]. intros m M.
      specialize (H m M). specialize (G m M). split.
      + intro N. apply Rmax_lub.
        * apply G. intro S. apply N. exists c. simpl; auto.
        * apply H. intros (v & I & S). apply N. exists v. simpl; auto.
      + intros L (v & [<-|I] & S).
        * pose proof (Rmax_l b d). apply G in S; [exact S | lra].
        * pose proof (Rmax_r b d). apply (proj2 H); [lra | eauto]. }
  exact (H (axes A B)).
Qed.

Theorem distance_exists A B : exists d, is_distance A B d.
Proof.
  destruct (all_axes_bound A B) as (d & D & H). exists d.
  assert (least : forall p q, holds A p -> holds B q -> d <= chebyshev p q).
  { intros p q P Q.
    assert (C : 0 <= chebyshev p q)
      by (refine (Rle_trans _ _ _ (Rabs_pos (x p - x q)) _); apply Rmax_l).
    apply (H _ C), (near_exactly A B _ C). exists p, q. repeat split; try assumption. lra. }
  split; [|exact least].
  destruct (proj2 (near_exactly A B d D) (proj2 (H d D) (Rle_refl d))) as (p & q & P & Q & L).
  exists p, q. repeat split; try assumption. pose proof (least p q P Q). lra.
Qed.

Theorem further_apart_exactly A B m d :
  0 <= m -> is_distance A B d -> m < d <-> some_axis_separates A B m.
Proof.
  intros M ((p & q & P & Q & E) & least).
  destruct (all_axes_bound A B) as (b & _ & H). specialize (H m M).
  pose proof (near_exactly A B m M) as N.
  assert (F : near A B m <-> d <= m).
  { split.
    - intros (u & v & U & V & L). pose proof (least u v U V). lra.
    - intro L. exists p, q. repeat split; try assumption. lra. }
  split; intro G.
  - destruct (Rle_dec b m) as [L | L].
    + exfalso. apply H, N, F in L. lra.
    + destruct (some_axis_or_none A B m) as [S | S]; [exact S|]. exfalso. apply L, H, S.
  - destruct (Rlt_dec m d) as [L | L]; [exact L|]. exfalso.
    apply (proj1 N); [apply F; lra | exact G].
Qed.
