(* What rounding a real scene to a grid costs (docs/theory.md, section 6). *)

From Triaxis Require Import Geometry.

(* A triangle whose vertices have moved by no more than d. *)
Definition moved (T T' : triangle) d := forall i, chebyshev (T i) (T' i) <= d.

Lemma weights_move_with_vertices T T' d w :
  moved T T' d -> (forall i, 0 <= w i) -> total w = 1 -> chebyshev (weighted w T) (weighted w T') <= d.
Proof.
  intros M W S. apply chebyshev_at_most.
  assert (part : forall f g : three -> R, (forall i, Rabs (f i - g i) <= d) ->
                 Rabs (total (fun i => w i * f i) - total (fun i => w i * g i)) <= d).
  { intros f g H.
    assert (E : total (fun i => w i * f i) - total (fun i => w i * g i) = total (fun i => w i * (f i - g i)))
      by (unfold total; ring).
    assert (both : forall i, - d <= f i - g i <= d).
    { intro i. specialize (H i). revert H. unfold Rabs. destruct Rcase_abs; lra. }
    rewrite E. apply Rabs_le.
    pose proof (total_at_most w (fun i => f i - g i) d 1 W S (fun i => proj2 (both i))).
    pose proof (total_at_least w (fun i => f i - g i) (- d) 1 W S (fun i => proj1 (both i))). lra. }
  unfold weighted; simpl. repeat split; apply part; intro i;
    destruct (proj1 (chebyshev_at_most _ _ _) (M i)) as (Hx & Hy & Hz); assumption.
Qed.

Lemma chebyshev_triangle u v w a b : chebyshev u v <= a -> chebyshev v w <= b -> chebyshev u w <= a + b.
Proof.
  rewrite !chebyshev_at_most. intros (Hx & Hy & Hz) (Gx & Gy & Gz).
  assert (part : forall p q s, Rabs (p - q) <= a -> Rabs (q - s) <= b -> Rabs (p - s) <= a + b).
  { intros p q s H G. replace (p - s) with ((p - q) + (q - s)) by ring.
    pose proof (Rabs_triang (p - q) (q - s)). lra. }
  repeat split; eapply part; eassumption.
Qed.

Lemma chebyshev_symmetric u v d : chebyshev u v <= d -> chebyshev v u <= d.
Proof.
  rewrite !chebyshev_at_most.
  rewrite (Rabs_minus_sym (x u)), (Rabs_minus_sym (y u)), (Rabs_minus_sym (z u)). tauto.
Qed.

Theorem near_after_moving A A' B B' a b m :
  moved A A' a -> moved B B' b -> near A B m -> near A' B' (m + a + b).
Proof.
  intros MA MB (p & q & (w & W & SW & ->) & (v & V & SV & ->) & H).
  exists (weighted w A'), (weighted v B').
  split; [exists w; tauto|]. split; [exists v; tauto|].
  replace (m + a + b) with (a + (m + b)) by ring.
  apply chebyshev_triangle with (weighted w A);
    [apply chebyshev_symmetric, weights_move_with_vertices; assumption|].
  apply chebyshev_triangle with (weighted v B); [exact H|].
  apply weights_move_with_vertices; assumption.
Qed.

Lemma moved_back T T' d : moved T T' d -> moved T' T d.
Proof. intros M i. apply chebyshev_symmetric, M. Qed.

(* Along a path: a question with a margin that is larger by h answers for all translations within h. *)
Theorem near_after_translation A B t h m :
  chebyshev zero t <= h -> near (fun i => add (A i) t) B m -> near A B (m + h).
Proof.
  intros T N. replace (m + h) with (m + h + 0) by ring.
  refine (near_after_moving _ A _ B h 0 m _ _ N).
  - intro i. apply chebyshev_at_most. apply chebyshev_at_most in T. unfold zero, add in *; simpl in *.
    rewrite Rabs_minus_sym in T. destruct T as (Tx & Ty & Tz).
    rewrite (Rabs_minus_sym 0 (y t)) in Ty. rewrite (Rabs_minus_sym 0 (z t)) in Tz.
    repeat split; [replace (x (A i) + x t - x (A i)) with (x t - 0) by ring
                  |replace (y (A i) + y t - y (A i)) with (y t - 0) by ring
                  |replace (z (A i) + z t - z (A i)) with (z t - 0) by ring]; assumption.
  - intro i. apply chebyshev_at_most. rewrite !Rminus_eq_0, Rabs_R0. lra.
Qed.

(* What is within c in the Euclidean distance is so in Chebyshev's. *)
Theorem euclidean_is_not_less u v c :
  0 <= c ->
  (x u - x v) * (x u - x v) + (y u - y v) * (y u - y v) + (z u - z v) * (z u - z v) <= c * c ->
  chebyshev u v <= c.
Proof.
  intros C H. apply chebyshev_at_most.
  pose proof (Rle_0_sqr (x u - x v)); pose proof (Rle_0_sqr (y u - y v)); pose proof (Rle_0_sqr (z u - z v)).
  unfold Rsqr in *.
  repeat split; apply Rabs_le; split; nra.
Qed.

Section Grid.

(* A grid of resolution r and offset o. *)
Variables (r : R) (o : vector).
Hypothesis r_positive : 0 < r.

Definition in_steps v := Vector ((x v - x o) / r) ((y v - y o) / r) ((z v - z o) / r).

Lemma weighted_in_steps w T :
  total w = 1 -> weighted w (fun i => in_steps (T i)) = in_steps (weighted w T).
Proof.
  intro S. unfold total in S.
  assert (E : w First = 1 - w Second - w Third) by lra.
  apply vector_equal; unfold weighted, total, in_steps; simpl; rewrite E; field; lra.
Qed.

Lemma chebyshev_in_steps u v d : chebyshev (in_steps u) (in_steps v) <= d <-> chebyshev u v <= d * r.
Proof.
  assert (part : forall a b k, Rabs ((a - k) / r - (b - k) / r) <= d <-> Rabs (a - b) <= d * r).
  { intros a b k.
    replace ((a - k) / r - (b - k) / r) with ((a - b) * / r) by (field; lra).
    rewrite Rabs_mult, (Rabs_pos_eq (/ r)) by (left; apply Rinv_0_lt_compat, r_positive).
    split; intro H.
    - apply (Rmult_le_compat_r r) in H; [|lra]. rewrite Rmult_assoc, Rinv_l in H; lra.
    - apply Rmult_le_reg_r with r; [exact r_positive|]. rewrite Rmult_assoc, Rinv_l; lra. }
  rewrite !chebyshev_at_most. unfold in_steps; simpl. rewrite !part. reflexivity.
Qed.

Lemma near_in_steps A B d :
  near (fun i => in_steps (A i)) (fun i => in_steps (B i)) d <-> near A B (d * r).
Proof.
  split.
  - intros (p & q & (w & W & SW & ->) & (v & V & SV & ->) & H).
    rewrite !weighted_in_steps in H by assumption. apply chebyshev_in_steps in H.
    exists (weighted w A), (weighted v B). split; [exists w; tauto | split; [exists v; tauto | exact H]].
  - intros (p & q & (w & W & SW & ->) & (v & V & SV & ->) & H).
    exists (in_steps (weighted w A)), (in_steps (weighted v B)).
    split; [exists w; rewrite weighted_in_steps by assumption; tauto|].
    split; [exists v; rewrite weighted_in_steps by assumption; tauto|].
    apply chebyshev_in_steps, H.
Qed.

(* A, B: the real triangles. A1, B1: as they were read, together off by no more than e. A2, B2: on the grid,
   each coordinate to the nearest integer, or any other within half a step. *)
Variables (A B A1 B1 A2 B2 : triangle) (a b e c : R) (k : Z).
Hypothesis A_read : moved A A1 a.
Hypothesis B_read : moved B B1 b.
Hypothesis reading : a + b <= e.
Hypothesis A_rounded : moved (fun i => in_steps (A1 i)) A2 (1 / 2).
Hypothesis B_rounded : moved (fun i => in_steps (B1 i)) B2 (1 / 2).

(* k is the ceiling of (c + e) / r, and the margin one more. *)
Hypothesis ceiling : IZR k - 1 < (c + e) / r <= IZR k.
Definition margin := IZR (k + 1).

Lemma near_at_most S T d d' : d <= d' -> near S T d -> near S T d'.
Proof. intros L (p & q & P & Q & H). exists p, q. repeat split; try assumption. lra. Qed.

Theorem nothing_is_missed : near A B c -> near A2 B2 margin.
Proof.
  intro N. apply (near_after_moving _ _ _ _ _ _ _ A_read B_read) in N.
  replace (c + a + b) with ((c + a + b) / r * r) in N by (field; lra).
  apply near_in_steps in N.
  apply (near_after_moving _ _ _ _ _ _ _ A_rounded B_rounded) in N.
  refine (near_at_most _ _ _ _ _ N). unfold margin. rewrite plus_IZR.
  assert ((c + a + b) / r <= (c + e) / r).
  { apply Rmult_le_compat_r; [left; apply Rinv_0_lt_compat, r_positive | lra]. }
  lra.
Qed.

Theorem false_alarms_are_in_a_band : near A2 B2 margin -> near A B ((margin + 1) * r + e).
Proof.
  intro N.
  apply (near_after_moving _ _ _ _ _ _ _ (moved_back _ _ _ A_rounded) (moved_back _ _ _ B_rounded)) in N.
  replace (margin + 1 / 2 + 1 / 2) with (margin + 1) in N by lra.
  apply near_in_steps in N.
  apply (near_after_moving _ _ _ _ _ _ _ (moved_back _ _ _ A_read) (moved_back _ _ _ B_read)) in N.
  refine (near_at_most _ _ _ _ _ N). lra.
Qed.

Theorem width_of_the_band : let band := (margin + 1) * r + e - c in 2 * r + 2 * e <= band < 3 * r + 2 * e.
Proof.
  unfold margin. rewrite plus_IZR. destruct ceiling as [L U].
  assert (E : (c + e) / r * r = c + e) by (field; lra).
  apply (Rmult_lt_compat_r r) in L; [|exact r_positive].
  apply (Rmult_le_compat_r r) in U; [|lra]. rewrite E in L, U. simpl. lra.
Qed.

End Grid.
