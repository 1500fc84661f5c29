(* A vector that separates can be moved to the cross product of two planes' normals (docs/theory.md,
   section 3): until it lies on two of the planes between which the order of all projections is fixed. *)

From Triaxis Require Import Geometry Separation.

(* The planes {c : c.h = 0}, by the vectors h: the edges of both triangles, and the unit vectors. *)
Inductive plane := EdgeA (i : three) | EdgeB (j : three) | Unit (k : three).

Definition edge (T : triangle) i := minus (T (next i)) (T i).

Definition unit k := match k with First => ex | Second => ey | Third => ez end.

Definition planes := map EdgeA threes ++ map EdgeB threes ++ map Unit threes.

Lemma in_planes p : In p planes.
Proof. destruct p as [[]|[]|[]]; simpl; tauto. Qed.

Lemma inner_of_sum c t d h : inner (add c (scale t d)) h = inner c h + t * inner d h.
Proof. unfold inner, add, scale; simpl; ring. Qed.

Lemma inner_commutes u v : inner u v = inner v u.
Proof. unfold inner; ring. Qed.

Lemma square_positive v : v <> zero -> 0 < inner v v.
Proof.
  intro H. destruct (Rlt_dec 0 (inner v v)) as [P | N]; [exact P|]. exfalso. apply H.
  assert (sq : forall a, 0 <= a * a) by (intro; apply Rle_0_sqr).
  assert (root : forall a, a * a = 0 -> a = 0) by (intros a E; apply Rmult_integral in E; tauto).
  unfold inner in N. pose proof (sq (x v)); pose proof (sq (y v)); pose proof (sq (z v)).
  apply vector_equal; apply root; simpl; lra.
Qed.

Lemma zero_or_not v : {v = zero} + {v <> zero}.
Proof.
  destruct (Req_EM_T (x v) 0), (Req_EM_T (y v) 0), (Req_EM_T (z v) 0);
    [left; apply vector_equal; simpl; assumption | right; intros ->; simpl in *; lra ..].
Qed.

(* The signs of a vector's coordinates: |c|1 is c.(signs c), and linear while the signs stay. *)
Definition sign a := if Rlt_dec 0 a then 1 else if Rlt_dec a 0 then -1 else 0.
Definition signs c := Vector (sign (x c)) (sign (y c)) (sign (z c)).

Lemma sign_cases a : 0 < a /\ sign a = 1 \/ a < 0 /\ sign a = -1 \/ a = 0 /\ sign a = 0.
Proof. unfold sign. repeat destruct Rlt_dec; lra. Qed.

Lemma norm1_by_signs c : norm1 c = inner c (signs c).
Proof.
  unfold norm1, inner, signs; simpl.
  assert (part : forall a, Rabs a = a * sign a).
  { intro a. destruct (sign_cases a) as [[H ->] | [[H ->] | [H ->]]];
      [rewrite Rabs_pos_eq | rewrite Rabs_left | rewrite H, Rabs_R0]; lra. }
  rewrite !part. reflexivity.
Qed.

Lemma same_side a b : ~ a * b < 0 -> (0 < a -> 0 <= b) /\ (a < 0 -> b <= 0).
Proof.
  intro N. split; intro H.
  - destruct (Rle_dec 0 b) as [L | L]; [exact L|]. exfalso. apply N.
    rewrite <- (Rmult_0_r a). apply Rmult_lt_compat_l; lra.
  - destruct (Rle_dec b 0) as [L | L]; [exact L|]. exfalso. apply N.
    rewrite <- (Rmult_0_l b). apply Rmult_lt_compat_r; lra.
Qed.

Section Pair.

Variables (A B : triangle) (m : R).

Definition across p := match p with EdgeA i => edge A i | EdgeB j => edge B j | Unit k => unit k end.

(* d lies on no other side of a plane than c, but may lie on more of them. *)
Definition agrees c d :=
  forall p, (0 <= inner c (across p) -> 0 <= inner d (across p)) /\
            (inner c (across p) <= 0 -> inner d (across p) <= 0).

Lemma agrees_on_plane c d p : agrees c d -> inner c (across p) = 0 -> inner d (across p) = 0.
Proof. intros H E. destruct (H p). lra. Qed.

Lemma order_agrees c d T i j :
  T = A \/ T = B -> agrees c d -> inner c (T j) <= inner c (T i) -> inner d (T j) <= inner d (T i).
Proof.
  intros HT H.
  assert (along : forall k, (inner c (T k) <= inner c (T (next k)) -> inner d (T k) <= inner d (T (next k)))
                         /\ (inner c (T (next k)) <= inner c (T k) -> inner d (T (next k)) <= inner d (T k))).
  { intro k.
    assert (E : forall v, inner v (edge T k) = inner v (T (next k)) - inner v (T k))
      by (intro; unfold inner, edge, minus; simpl; ring).
    destruct HT as [-> | ->]; [destruct (H (EdgeA k)) as [P N] | destruct (H (EdgeB k)) as [P N]];
      simpl in P, N; rewrite !E in P, N; split; intro; lra. }
  pose proof (along First) as [? ?]; pose proof (along Second) as [? ?]; pose proof (along Third) as [? ?].
  simpl in *. destruct i, j; auto using Rle_refl.
Qed.

Lemma signs_agree c d : agrees c d -> norm1 d = inner d (signs c).
Proof.
  intro H.
  assert (part : forall a b, (0 <= a -> 0 <= b) -> (a <= 0 -> b <= 0) -> Rabs b = b * sign a).
  { intros a b P N. destruct (sign_cases a) as [[Ha ->] | [[Ha ->] | [Ha ->]]].
    - rewrite Rabs_pos_eq; lra.
    - rewrite Rabs_left1; lra.
    - replace b with 0 by lra. rewrite Rabs_R0. ring. }
  assert (coordinates : forall v, inner v ex = x v /\ inner v ey = y v /\ inner v ez = z v)
    by (intro; unfold inner, ex, ey, ez; simpl; repeat split; ring).
  pose proof (H (Unit First)) as [Px Nx]; pose proof (H (Unit Second)) as [Py Ny].
  pose proof (H (Unit Third)) as [Pz Nz]. simpl in *.
  destruct (coordinates c) as (Cx & Cy & Cz), (coordinates d) as (Dx & Dy & Dz).
  rewrite Cx, Dx in *. rewrite Cy, Dy in *. rewrite Cz, Dz in *.
  unfold norm1, inner, signs; simpl.
  rewrite (part _ _ Px Nx), (part _ _ Py Ny), (part _ _ Pz Nz). reflexivity.
Qed.

(* On the cell of c, how far c is ahead is linear: its inner product with one vector. *)
Lemma linear_on_cell c :
  exists l, (ahead c A B m -> 0 < inner c l) /\ (forall d, agrees c d -> 0 < inner d l -> ahead d A B m).
Proof.
  destruct (largest (fun i => inner c (A i))) as [i Hi].
  destruct (largest (fun j => - inner c (B j))) as [j Hj].
  exists (minus (minus (B j) (A i)) (scale m (signs c))).
  assert (E : forall v, inner v (minus (minus (B j) (A i)) (scale m (signs c)))
                        = inner v (B j) - inner v (A i) - m * inner v (signs c))
    by (intro; unfold inner, minus, scale; simpl; ring).
  split.
  - intro H. specialize (H i j). rewrite E, <- norm1_by_signs. lra.
  - intros d H P i' j'. rewrite E, <- (signs_agree c d H) in P.
    pose proof (order_agrees c d A i i' (or_introl eq_refl) H (Hi i')).
    assert (Hb : inner c (B j) <= inner c (B j')) by (specialize (Hj j'); simpl in Hj; lra).
    pose proof (order_agrees c d B j' j (or_intror eq_refl) H Hb). lra.
Qed.

(* Along c + t d, t > 0, up to the first plane. *)
Lemma first_hit c d :
  (exists p, inner c (across p) * inner d (across p) < 0) ->
  (forall p, inner c (across p) = 0 -> inner d (across p) = 0) ->
  exists t, 0 < t /\ agrees c (add c (scale t d)) /\
            exists p, inner (add c (scale t d)) (across p) = 0 /\ inner d (across p) <> 0.
Proof.
  intros Hit Stay.
  set (hits p := inner c (across p) * inner d (across p) < 0).
  set (time p := - inner c (across p) / inner d (across p)).
  set (hitting := filter (fun p => if Rlt_dec (inner c (across p) * inner d (across p)) 0 then true else false)).
  assert (in_hitting : forall p, In p (hitting planes) <-> hits p).
  { intro p. unfold hitting, hits. rewrite filter_In. pose proof (in_planes p).
    destruct Rlt_dec; intuition congruence. }
  destruct (extreme (fun p => - time p) (hitting planes)) as [none | (p & Hp & Sp)].
  { exfalso. destruct Hit as [p H]. apply (in_nil (a := p)). rewrite <- none. apply in_hitting, H. }
  apply in_hitting in Hp.
  assert (nonzero : inner d (across p) <> 0) by (intro Z; unfold hits in Hp; rewrite Z in Hp; lra).
  exists (time p).
  assert (positive : 0 < time p).
  { unfold time, hits in *. apply Rmult_lt_reg_r with (inner d (across p) * inner d (across p)).
    - exact (Rsqr_pos_lt _ nonzero).
    - replace (- inner c (across p) / inner d (across p) * (inner d (across p) * inner d (across p)))
        with (- (inner c (across p) * inner d (across p))) by (field; exact nonzero). lra. }
  split; [exact positive|]. split.
  - intro q. rewrite inner_of_sum. pose proof (fun S => Sp q (proj2 (in_hitting q) S)) as Sq. unfold hits, time in Sq.
    destruct (Rtotal_order (inner c (across q)) 0) as [Lt | [Eq | Gt]].
    + split; [lra|]. intros _. destruct (Rle_dec (inner d (across q)) 0) as [Le | Pos]; [nra|].
      assert (S : inner c (across q) * inner d (across q) < 0) by nra. specialize (Sq S). apply Ropp_le_cancel in Sq.
      apply (Rmult_le_compat_r (inner d (across q))) in Sq; [|lra].
      replace (- inner c (across q) / inner d (across q) * inner d (across q)) with (- inner c (across q))
        in Sq by (field; lra).
      unfold time. lra.
    + rewrite Eq, (Stay q Eq). lra.
    + split; [|lra]. intros _. destruct (Rle_dec 0 (inner d (across q))) as [Le | Neg]; [nra|].
      assert (S : inner c (across q) * inner d (across q) < 0) by nra. specialize (Sq S). apply Ropp_le_cancel in Sq.
      apply (Rmult_le_compat_r (- inner d (across q))) in Sq; [|lra].
      replace (- inner c (across q) / inner d (across q) * - inner d (across q)) with (inner c (across q))
        in Sq by (field; lra).
      unfold time. lra.
  - exists p. split; [|exact nonzero]. rewrite inner_of_sum. unfold time. field. exact nonzero.
Qed.

(* One step: along a d on which |.|1 stays, one of the two ways loses nothing and meets a further plane. *)
Lemma step c d :
  ahead c A B m -> d <> zero -> inner (signs c) d = 0 ->
  (forall p, inner c (across p) = 0 -> inner d (across p) = 0) ->
  exists c', ahead c' A B m /\ agrees c c' /\ exists p, inner c' (across p) = 0 /\ inner d (across p) <> 0.
Proof.
  intros H D S Stay.
  destruct (linear_on_cell c) as (l & Hl & Hc). specialize (Hl H).
  assert (either : forall e, (e = d \/ e = scale (-1) d) -> exists p, inner c (across p) * inner e (across p) < 0).
  { intros e He.
    assert (S' : inner (signs c) e = 0)
      by (destruct He as [-> | ->]; unfold inner, scale, signs in *; simpl in *; lra).
    assert (D' : e <> zero).
    { destruct He as [-> | ->]; [exact D|]. intro Z. apply D.
      unfold scale, zero in Z. injection Z as Zx Zy Zz. apply vector_equal; simpl; lra. }
    assert (Stay' : forall k, inner c (unit k) = 0 -> inner e (unit k) = 0).
    { intros k Z. specialize (Stay (Unit k) Z). simpl in Stay.
      destruct He as [-> | ->]; [exact Stay|]. destruct k; unfold inner, scale in *; simpl in *; lra. }
    assert (one : x c * x e < 0 \/ y c * y e < 0 \/ z c * z e < 0).
    { pose proof (Stay' First) as Zx; pose proof (Stay' Second) as Zy; pose proof (Stay' Third) as Zz.
      unfold inner, signs in *; simpl in *.
      destruct (Rlt_dec (x c * x e) 0), (Rlt_dec (y c * y e) 0), (Rlt_dec (z c * z e) 0); try tauto.
      exfalso. apply D'.
      assert (part : forall a b, (a = 0 -> b = 0) -> ~ a * b < 0 -> 0 <= sign a * b /\ (sign a * b = 0 -> b = 0)).
      { intros a b Z N. destruct (sign_cases a) as [[Ha ->] | [[Ha ->] | [Ha ->]]].
        - pose proof (proj1 (same_side a b N) Ha). lra.
        - pose proof (proj2 (same_side a b N) Ha). lra.
        - rewrite (Z Ha). lra. }
      destruct (part (x c) (x e)) as [Px Qx]; [intro; lra | assumption |].
      destruct (part (y c) (y e)) as [Py Qy]; [intro; lra | assumption |].
      destruct (part (z c) (z e)) as [Pz Qz]; [intro; lra | assumption |].
      apply vector_equal; simpl; [apply Qx | apply Qy | apply Qz]; lra. }
    destruct one as [O | [O | O]]; [exists (Unit First) | exists (Unit Second) | exists (Unit Third)];
      unfold inner; simpl; lra. }
  assert (way : forall e, (e = d \/ e = scale (-1) d) -> 0 <= inner e l ->
    exists c', ahead c' A B m /\ agrees c c' /\ exists p, inner c' (across p) = 0 /\ inner d (across p) <> 0).
  { intros e He L.
    assert (same : forall v, inner e v = 0 <-> inner d v = 0)
      by (intro; destruct He as [-> | ->]; unfold inner, scale; simpl; split; lra).
    destruct (first_hit c e (either e He)) as (t & T & G & p & Z & N).
    { intros p Z. apply same, Stay, Z. }
    exists (add c (scale t e)). split; [|split; [exact G|]].
    - apply Hc; [exact G|]. rewrite inner_of_sum. nra.
    - exists p. split; [exact Z|]. intro F. apply N, same, F. }
  destruct (Rle_dec 0 (inner d l)) as [P | P].
  - exact (way d (or_introl eq_refl) P).
  - apply (way (scale (-1) d) (or_intror eq_refl)). unfold inner, scale in *; simpl in *. lra.
Qed.

Lemma ahead_is_not_zero c : ahead c A B m -> c <> zero.
Proof.
  intros H ->. specialize (H First First).
  unfold inner, norm1, zero in H; simpl in H. rewrite Rabs_R0 in H. lra.
Qed.

Lemma some_plane (f : plane -> Prop) :
  (forall p, {f p} + {~ f p}) -> (exists p, f p) \/ (forall p, ~ f p).
Proof.
  intro dec. destruct (Exists_dec f planes dec) as [E | N].
  - left. apply Exists_exists in E. destruct E as (p & _ & F). eauto.
  - right. intros p F. apply N, Exists_exists. eauto using in_planes.
Qed.

Lemma onto_one_plane c :
  ahead c A B m -> exists c' p, ahead c' A B m /\ across p <> zero /\ inner c' (across p) = 0.
Proof.
  intro H.
  destruct (some_plane (fun p => across p <> zero /\ inner c (across p) = 0)) as [(p & Hp) | N].
  { intro p. destruct (zero_or_not (across p)); [right; tauto|].
    destruct (Req_EM_T (inner c (across p)) 0); [left | right]; tauto. }
  { exists c, p. tauto. }
  destruct (step c (Vector (sign (y c)) (- sign (x c)) 0) H) as (c' & H' & _ & p & Z & D).
  - intro Z. injection Z as Zy Zx.
    apply (N (Unit Second)). split.
    + intro E. injection E. lra.
    + simpl. destruct (sign_cases (y c)) as [[? ?] | [[? ?] | [? ?]]]; unfold inner; simpl; lra.
  - unfold inner, signs; simpl. ring.
  - intros p Z. destruct (zero_or_not (across p)) as [-> | E].
    + unfold inner; simpl; ring.
    + exfalso. apply (N p). tauto.
  - exists c', p. split; [exact H'|]. split; [|exact Z].
    intro E. rewrite E in D. apply D. unfold inner; simpl; ring.
Qed.

Lemma onto_two_planes c p :
  ahead c A B m -> across p <> zero -> inner c (across p) = 0 ->
  exists c' q, ahead c' A B m /\ inner c' (across p) = 0 /\ inner c' (across q) = 0 /\
               cross (across p) (across q) <> zero.
Proof.
  intros H P Z.
  set (h := across p) in *.
  destruct (some_plane (fun q => cross h (across q) <> zero /\ inner c (across q) = 0)) as [(q & Hq) | N].
  { intro q. destruct (zero_or_not (cross h (across q))); [right; tauto|].
    destruct (Req_EM_T (inner c (across q)) 0); [left | right]; tauto. }
  { exists c, q. tauto. }
  assert (mixed : forall g, inner (cross h (signs c)) g = - inner (signs c) (cross h g))
    by (intro; unfold inner, cross; simpl; ring).
  destruct (step c (cross h (signs c)) H) as (c' & H' & G & q & Z' & D).
  - intro E. apply (ahead_is_not_zero c H).
    assert (S : inner c (signs c) = 0).
    { apply Rmult_eq_reg_l with (inner h h); [|pose proof (square_positive h P); lra].
      assert (T : inner h h * inner c (signs c)
                  = inner c h * inner h (signs c) + inner c (cross (cross h (signs c)) h))
        by (unfold inner, cross; simpl; ring).
      rewrite T, E, Z. unfold inner, cross; simpl; ring. }
    rewrite <- norm1_by_signs in S. exact (norm1_of_zero_alone c S).
  - rewrite inner_commutes, mixed. unfold inner, cross; simpl; ring.
  - intros q Zq. rewrite mixed. destruct (zero_or_not (cross h (across q))) as [-> | E].
    + unfold inner; simpl; ring.
    + exfalso. apply (N q). tauto.
  - exists c', q. split; [exact H'|]. split; [|split; [exact Z'|]].
    + exact (agrees_on_plane c c' p G Z).
    + intro E. apply D. rewrite mixed, E. unfold inner; simpl; ring.
Qed.

Lemma ahead_of_multiple c k : 0 < k -> ahead (scale k c) A B m -> ahead c A B m.
Proof.
  intros K H i j. specialize (H i j).
  assert (Ni : norm1 (scale k c) = k * norm1 c).
  { unfold norm1, scale; simpl. rewrite !Rabs_mult, (Rabs_pos_eq k) by lra. ring. }
  assert (I : forall v, inner (scale k c) v = k * inner c v) by (intro; unfold inner, scale; simpl; ring).
  rewrite Ni, !I in H. apply Rmult_lt_reg_l with k; [exact K|]. lra.
Qed.

End Pair.

Lemma ahead_backwards c A B m : ahead (scale (-1) c) A B m -> ahead c B A m.
Proof.
  intros H i j. specialize (H j i).
  assert (Ni : norm1 (scale (-1) c) = norm1 c).
  { unfold norm1, scale; simpl. rewrite !Rabs_mult, Rabs_left by lra. ring. }
  assert (I : forall v, inner (scale (-1) c) v = - inner c v) by (intro; unfold inner, scale; simpl; ring).
  rewrite Ni, !I in H. lra.
Qed.

Lemma separates_backwards c A B m : separates (scale (-1) c) A B m -> separates c A B m.
Proof. intros [H | H]; [right | left]; apply ahead_backwards, H. Qed.

Lemma along_and_across n c : scale (inner n n) c = add (scale (inner n c) n) (cross (cross n c) n).
Proof. by_coordinates; unfold inner; ring. Qed.

Lemma product_across g h c : cross (cross g h) c = minus (scale (inner c g) h) (scale (inner c h) g).
Proof. by_coordinates; unfold inner; ring. Qed.

Theorem some_cross_product_separates A B m c :
  ahead c A B m -> exists p q, separates (cross (across A B p) (across A B q)) A B m.
Proof.
  intro H.
  destruct (onto_one_plane A B m c H) as (c1 & p & H1 & P & Z1).
  destruct (onto_two_planes A B m c1 p H1 P Z1) as (c2 & q & H2 & Zp & Zq & D).
  exists p, q. set (n := cross (across A B p) (across A B q)) in *.
  pose proof (square_positive n D) as N.
  set (k := inner n c2 / inner n n).
  assert (E : c2 = scale k n).
  { assert (T : scale (inner n n) c2 = scale (inner n c2) n).
    { rewrite (along_and_across n c2).
      assert (L : cross n c2 = zero).
      { unfold n. rewrite product_across, Zp, Zq. by_coordinates; ring. }
      rewrite L. by_coordinates; ring. }
    unfold scale in T. injection T as Tx Ty Tz.
    apply vector_equal; unfold k; simpl;
      (apply Rmult_eq_reg_l with (inner n n); [|lra]);
      [rewrite Tx | rewrite Ty | rewrite Tz]; field; lra. }
  destruct (Rtotal_order k 0) as [L | [Z | G]].
  - right. apply ahead_backwards, (ahead_of_multiple A B m _ (- k)); [lra|].
    replace (scale (- k) (scale (-1) n)) with c2; [exact H2|].
    rewrite E. by_coordinates; ring.
  - exfalso. apply (ahead_is_not_zero A B m c2 H2). rewrite E, Z. by_coordinates; ring.
  - left. apply (ahead_of_multiple A B m _ k G). rewrite <- E. exact H2.
Qed.
