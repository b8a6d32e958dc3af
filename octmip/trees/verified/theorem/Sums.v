(** Facts about sums over samples, about vectors, and about the numbers of a sample. *)

From Coq Require Import ZArith List Bool Permutation Lia Arith.
Import ListNotations.
From octmip Require Import Samples.
Open Scope Z_scope.

Lemma total_app what l l' : total what (l ++ l') = total what l + total what l'.
Proof. induction l; simpl; lia. Qed.

Lemma total_perm what l l' : Permutation l l' -> total what l = total what l'.
Proof. induction 1; simpl; lia. Qed.

Lemma total_filter what keep l :
  total what l = total what (filter keep l) + total what (filter (fun s => negb (keep s)) l).
Proof. induction l as [|s l IH]; simpl; [lia|]. destruct (keep s); simpl; lia. Qed.

Lemma total_le f g l : (forall s, In s l -> f s <= g s) -> total f l <= total g l.
Proof.
  induction l as [|s l IH]; simpl; intros H; [lia|].
  assert (f s <= g s) by (apply H; auto). assert (total f l <= total g l) by (apply IH; auto). lia.
Qed.

Lemma total_ext f g l : (forall s, In s l -> f s = g s) -> total f l = total g l.
Proof. intros H. apply Z.le_antisymm; apply total_le; intros s I; rewrite H; auto; lia. Qed.

Lemma total_minus f g l : total (fun s => f s - g s) l = total f l - total g l.
Proof. induction l; simpl; lia. Qed.

Lemma total_one l : total (fun _ => 1) l = Z.of_nat (length l).
Proof. induction l as [|s l IH]; cbn [length total]; [reflexivity|]. rewrite Nat2Z.inj_succ, IH. lia. Qed.

Lemma total_nonneg f l : (forall s, In s l -> 0 <= f s) -> 0 <= total f l.
Proof.
  induction l as [|s l IH]; simpl; intros H; [lia|].
  assert (0 <= f s) by (apply H; auto). assert (0 <= total f l) by (apply IH; auto). lia.
Qed.

(** * Vectors *)

Lemma nth_nil (A : Type) i (d : A) : nth i [] d = d.
Proof. destruct i; reflexivity. Qed.

Lemma nth_add u : forall v i, nth i (add u v) 0 = nth i u 0 + nth i v 0.
Proof.
  induction u as [|x u IH]; intros [|y v] i; try (destruct i; simpl; lia).
  destruct i; simpl; [lia|apply IH].
Qed.

(** The sum of vectors of samples. *)
Definition joined (what : sample -> list Z) (l : list sample) (start : list Z) : list Z :=
  fold_left (fun v s => add v (what s)) l start.

Lemma nth_joined what l : forall start i,
  nth i (joined what l start) 0 = nth i start 0 + total (fun s => nth i (what s) 0) l.
Proof.
  unfold joined. induction l as [|s l IH]; intros; simpl; [lia|]. rewrite IH, nth_add. lia.
Qed.

Lemma outside_add : forall u v places, outside places (add u v) = outside places u + outside places v.
Proof.
  induction u as [|x u IH]; intros [|y v] places; simpl; try lia.
  rewrite IH. destruct (has places 0); lia.
Qed.

Lemma outside_joined what places l : forall start,
  outside places (joined what l start) = outside places start + total (fun s => outside places (what s)) l.
Proof.
  unfold joined. induction l as [|s l IH]; intros; simpl; [lia|]. rewrite IH, outside_add. lia.
Qed.

Lemma nth_le_top v : forall i, nth i v 0 <= top v.
Proof.
  induction v as [|x v IH]; intros i; [rewrite nth_nil; simpl; lia|].
  destruct i; simpl; [lia|]. specialize (IH i). lia.
Qed.

Lemma top_nonneg v : 0 <= top v.
Proof. induction v; simpl; lia. Qed.

Lemma top_le v most : 0 <= most -> (forall i, nth i v 0 <= most) -> top v <= most.
Proof.
  intros P. induction v as [|x v IH]; simpl; intros H; [lia|].
  assert (x <= most) by apply (H 0%nat). assert (top v <= most) by (apply IH; intros i; apply (H (S i))). lia.
Qed.

Lemma top_gap_nonneg u : forall v, 0 <= top_gap u v.
Proof.
  induction u as [|x u IH]; intros [|y v]; simpl; try lia; [apply (top_nonneg (x :: u))|specialize (IH v); lia].
Qed.

Lemma nth_le_top_gap u : forall v i, (i < length u)%nat -> nth i u 0 - nth i v 0 <= top_gap u v.
Proof.
  induction u as [|x u IH]; intros v i L; [simpl in L; lia|].
  destruct v as [|y v].
  - rewrite nth_nil. change (top_gap (x :: u) []) with (top (x :: u)). assert (H := nth_le_top (x :: u) i). lia.
  - destruct i; simpl; [lia|]. simpl in L. specialize (IH v i). lia.
Qed.

Lemma top_gap_le u : forall v most, 0 <= most -> (forall i, (i < length u)%nat -> nth i u 0 - nth i v 0 <= most) ->
  top_gap u v <= most.
Proof.
  induction u as [|x u IH]; intros v most P H; [simpl; lia|].
  destruct v as [|y v].
  - change (top_gap (x :: u) []) with (top (x :: u)). apply top_le; [lia|]. intros i.
    destruct (Nat.lt_ge_cases i (length (x :: u))) as [L|L].
    + specialize (H i L). rewrite nth_nil in H. lia.
    + rewrite nth_overflow by lia. lia.
  - simpl. assert (x - y <= most) by (apply (H 0%nat); simpl; lia).
    assert (top_gap u v <= most) by (apply IH; auto; intros i L; apply (H (S i)); simpl; lia). lia.
Qed.

Lemma nth_trimmed v : forall i, nth i (trimmed v) 0 = nth i v 0.
Proof.
  induction v as [|x v IH]; intros i; [reflexivity|].
  assert (E : trimmed (x :: v) = match trimmed v with [] => if x =? 0 then [] else [x] | _ => x :: trimmed v end)
    by reflexivity.
  rewrite E. destruct (trimmed v) as [|y w].
  - assert (Zero : forall j, nth j v 0 = 0) by (intros j; rewrite <- IH; apply nth_nil).
    destruct (Z.eqb_spec x 0) as [X|X]; destruct i as [|i]; simpl; rewrite ?Zero; try destruct i; auto.
  - destruct i; [reflexivity|]. apply IH.
Qed.

Lemma trimmed_length v : (length (trimmed v) <= length v)%nat.
Proof.
  induction v as [|x v IH]; [simpl; lia|].
  assert (E : trimmed (x :: v) = match trimmed v with [] => if x =? 0 then [] else [x] | _ => x :: trimmed v end)
    by reflexivity.
  rewrite E. destruct (trimmed v) as [|y w]; [destruct (x =? 0)|]; simpl in *; lia.
Qed.

(** * The numbers of a sample *)

(** What the checker believes of a sample, for labels below [n_labels]. *)
Record sound (n_labels : nat) (s : sample) : Prop := {
  price_nonneg : forall label, (label < n_labels)%nat -> 0 <= price label s;
  price_gain : forall label, (label < n_labels)%nat -> price label s = worst s - gain label s;
  worst_nonneg : 0 <= worst s;
  gain_range : forall label, 0 <= gain label s <= reach s;
  more_nonneg : Forall (fun x => 0 <= x) (more s);
  price_more : forall label, (label < n_labels)%nat -> sure s + outside [label] (more s) <= price label s;
  width_nonneg : 0 <= width s;
  gains_length : (length (gains s) <= n_labels)%nat;
  packed_gains : packed s = pack (width s) (gains s)
}.

Lemma price_le_worst n s label : sound n s -> (label < n)%nat -> price label s <= worst s.
Proof. intros H L. rewrite (price_gain n s H) by auto. assert (G := gain_range n s H label). lia. Qed.

Lemma least_spec v : forall i, (i < length v)%nat -> or_zero (least v) <= nth i v 0.
Proof.
  induction v as [|x v IH]; intros i L; [simpl in L; lia|]. simpl.
  destruct v as [|y v]; [destruct i; simpl in *; lia|].
  destruct (least (y :: v)) as [m|] eqn:E; [|simpl in E; destruct (least v); discriminate].
  simpl or_zero in *. destruct i; [simpl; lia|]. simpl in L. specialize (IH i). simpl nth. simpl in IH.
  assert (m <= nth i (y :: v) 0) by (apply IH; simpl; lia). simpl in *. lia.
Qed.

Lemma least_nonneg v : Forall (fun x => 0 <= x) v -> 0 <= or_zero (least v).
Proof.
  induction 1 as [|x v P H IH]; simpl; [lia|]. destruct (least v); simpl in *; lia.
Qed.

Lemma without_spec place : forall v i, i <> place -> (i < length v)%nat ->
  exists j, (j < length (without place v))%nat /\ nth j (without place v) 0 = nth i v 0.
Proof.
  induction place as [|place IH]; intros [|x v] i N L; simpl in L; try lia.
  - destruct i; [lia|]. exists i. simpl. split; [lia|reflexivity].
  - destruct i; [exists 0%nat; simpl; split; [lia|reflexivity]|].
    destruct (IH v i) as (j & J & E); [lia|lia|]. exists (S j). simpl. split; [lia|exact E].
Qed.

Lemma has_one place other : has [place] other = Nat.eqb other place.
Proof. unfold has. simpl. apply orb_false_r. Qed.

Lemma outside_nil v : outside [] v = sum v.
Proof. induction v; simpl; [reflexivity|]. change (beyond_first []) with (@nil nat). lia. Qed.

Lemma sum_of_one n extra : sum (repeat 0 n ++ [extra]) = extra.
Proof. induction n; simpl; lia. Qed.

Lemma outside_one favourite extra : forall label,
  outside [label] (repeat 0 favourite ++ [extra]) = if Nat.eqb label favourite then 0 else extra.
Proof.
  induction favourite as [|f IH]; intros label; cbn [repeat app outside]; rewrite has_one.
  - destruct label; simpl; lia.
  - destruct label as [|label]; simpl Nat.eqb; cbv iota.
    + change (beyond_first [0%nat]) with (@nil nat). rewrite outside_nil, sum_of_one. reflexivity.
    + change (beyond_first [S label]) with [label]. rewrite IH. reflexivity.
Qed.

Theorem sample_of_sound its_width its_keys its_prices favourite : 0 <= its_width ->
  Forall (fun x => 0 <= x) its_prices -> sound (length its_prices) (sample_of its_width its_keys its_prices favourite).
Proof.
  intros W P.
  assert (N : forall label, 0 <= nth label its_prices 0).
  { intros label. destruct (Nat.lt_ge_cases label (length its_prices)) as [L|L].
    - rewrite Forall_forall in P. apply P, nth_In, L.
    - rewrite nth_overflow; lia. }
  assert (G : forall label, (label < length its_prices)%nat ->
    gain label (sample_of its_width its_keys its_prices favourite) = top its_prices - nth label its_prices 0).
  { intros label L. unfold gain, sample_of; simpl. rewrite nth_trimmed.
    rewrite nth_indep with (d' := top its_prices - 0) by (rewrite map_length; exact L).
    apply (map_nth (fun x => top its_prices - x)). }
  constructor.
  - intros label _. apply N.
  - intros label L. rewrite G by exact L. unfold price; simpl. lia.
  - apply top_nonneg.
  - intros label. destruct (Nat.lt_ge_cases label (length its_prices)) as [L|L].
    + rewrite G by exact L. simpl. assert (A := nth_le_top its_prices label).
      assert (B := least_spec its_prices label L). lia.
    + unfold gain, sample_of; simpl. rewrite nth_trimmed, nth_overflow by (rewrite map_length; lia).
      destruct its_prices as [|x its_prices]; [simpl; lia|].
      assert (A := nth_le_top (x :: its_prices) 0). assert (B := least_spec (x :: its_prices) 0).
      simpl length in B. simpl nth in A, B. lia.
  - unfold sample_of; simpl.
    destruct (Z.leb_spec (or_zero (least (without favourite its_prices)) - or_zero (least its_prices)) 0);
      [constructor|].
    apply Forall_app. split; [|repeat constructor; lia]. clear. induction favourite; simpl; constructor; auto; lia.
  - intros label L. unfold sample_of, price; simpl.
    assert (B := least_spec its_prices label L).
    destruct (Z.leb_spec (or_zero (least (without favourite its_prices)) - or_zero (least its_prices)) 0); [simpl;
      lia|].
    rewrite outside_one. destruct (Nat.eqb_spec label favourite); [lia|].
    destruct (without_spec favourite its_prices label) as (j & J & E); [lia|lia|].
    assert (M := least_spec _ j J). lia.
  - exact W.
  - unfold sample_of; simpl. assert (T := trimmed_length (map (fun x => top its_prices - x) its_prices)).
    rewrite map_length in T. exact T.
  - reflexivity.
Qed.
