(** The bounds of the sides of cuts are bounds: spread, growing and shrinking along an order. *)

From Coq Require Import ZArith List Bool Permutation Lia Arith.
Import ListNotations.
From octmip Require Import Samples Sums Trees Inequalities Sides.
Open Scope Z_scope.
Local Arguments Z.add : simpl never.
Local Arguments Z.sub : simpl never.
Local Arguments Z.mul : simpl never.

(** * Spread *)

Lemma nth_leave_out x : forall sums previous i, (i < length sums)%nat ->
  nth i (leave_out x previous sums) 0 = Z.min (x + nth i sums 0) (nth i (previous :: sums) 0).
Proof.
  induction sums as [|y sums IH]; intros previous i L; simpl in L; [lia|].
  destruct i; [reflexivity|]. simpl leave_out. simpl nth at 1 2. rewrite IH by lia. reflexivity.
Qed.

Lemma leave_out_length x : forall sums previous, length (leave_out x previous sums) = length sums.
Proof. induction sums; simpl; auto. Qed.

Lemma least_sums_length zeros v : length (least_sums zeros v) = length zeros.
Proof.
  induction v as [|x v IH]; simpl; [reflexivity|].
  destruct (least_sums zeros v) as [|y rest]; simpl in *; [auto|]. rewrite leave_out_length. exact IH.
Qed.

Lemma beyond_first_length places :
  (length (beyond_first places) + (if has places 0 then 1 else 0) <= length places)%nat.
Proof.
  unfold beyond_first, has. rewrite map_length. induction places as [|p places IH]; [simpl; lia|].
  cbn [existsb filter]. destruct (Nat.eqb_spec 0 p) as [<-|N].
  - cbn [Nat.eqb negb orb length]. destruct (existsb (Nat.eqb 0) places); lia.
  - destruct (Nat.eqb_spec p 0); [congruence|]. cbn [negb orb length].
    destruct (existsb (Nat.eqb 0) places); lia.
Qed.

Lemma least_sums_le c v : forall places i, (length places <= i)%nat -> (i <= c)%nat ->
  nth i (least_sums (repeat 0 (S c)) v) 0 <= outside places v.
Proof.
  induction v as [|x v IH]; intros places i L C.
  - cbn [least_sums outside]. rewrite nth_repeat. lia.
  - cbn [least_sums outside]. assert (N := least_sums_length (repeat 0 (S c)) v). rewrite repeat_length in N.
    assert (B := beyond_first_length places).
    destruct (least_sums (repeat 0 (S c)) v) as [|y rest] eqn:E; [discriminate|]. simpl in N.
    destruct i.
    + assert (places = []) by (destruct places; [auto|simpl in L; lia]). subst.
      simpl. apply Z.add_le_mono_l. apply (IH [] 0%nat); lia.
    + cbn [nth]. rewrite nth_leave_out by lia.
      destruct (has places 0).
      * assert (H := IH (beyond_first places) i). lia.
      * assert (H := IH (beyond_first places) (S i)). cbn [nth] in H. lia.
Qed.

Lemma last_nth (l : list Z) d : l <> [] -> last l d = nth (length l - 1) l d.
Proof.
  induction l as [|x l IH]; intros H; [congruence|]. destruct l as [|y l]; [reflexivity|].
  change (last (x :: y :: l) d) with (last (y :: l) d). rewrite IH by discriminate.
  simpl length. replace (S (S (length l)) - 1)%nat with (S (S (length l) - 1)) by lia. reflexivity.
Qed.

Lemma outside_mono v : Forall (fun x => 0 <= x) v -> forall few many,
  (forall place, has few place = true -> has many place = true) -> outside many v <= outside few v.
Proof.
  induction 1 as [|x v P H IH]; intros few many Sub; simpl; [lia|].
  assert (G : outside (beyond_first many) v <= outside (beyond_first few) v).
  { apply IH. intros place. unfold has, beyond_first. rewrite !existsb_exists.
    intros (q & Q & E). apply in_map_iff in Q. destruct Q as (q' & Q' & I). apply filter_In in I.
    destruct I as [I N]. assert (T : has many (S place) = true).
    { apply Sub. unfold has. apply existsb_exists. exists q'. split; [exact I|].
      apply Nat.eqb_eq in E. destruct q'; [discriminate|]. simpl in Q'. apply Nat.eqb_eq. lia. }
    unfold has in T. apply existsb_exists in T. destruct T as (z & Z1 & Z2). exists (Nat.pred z).
    apply Nat.eqb_eq in Z2. split; [|apply Nat.eqb_eq; lia]. apply in_map_iff. exists z. split; [reflexivity|].
    apply filter_In. split; [exact Z1|]. subst. reflexivity. }
  assert (S0 := Sub 0%nat). destruct (has few 0), (has many 0); try lia.
Qed.

Lemma outside_nonneg v : Forall (fun x => 0 <= x) v -> forall places, 0 <= outside places v.
Proof.
  induction 1 as [|x v P H IH]; intros places; simpl; [lia|]. specialize (IH (beyond_first places)).
  destruct (has places 0); lia.
Qed.

Section Rules.
Variable r : rules.
Hypothesis penalty_nonneg : 0 <= penalty r.

Theorem spread_spec d m : all_sound r m ->
  spreads r d m (total sure m + spread (label_count (n_labels r) d) (joined more m [])).
Proof.
  intros S t T D. unfold all_sound in S. rewrite Forall_forall in S.
  assert (P : total sure m + outside (labels t) (joined more m []) <= paid t m).
  { rewrite outside_joined. cbn [outside]. replace (total sure m + (0 + _)) with
      (total (fun s => sure s - - outside (labels t) (more s)) m) by (rewrite total_minus;
      replace (total (fun s => - outside (labels t) (more s)) m) with
        (total (fun s => 0 - outside (labels t) (more s)) m) by (apply total_ext; intros; lia);
      rewrite total_minus; replace (total (fun _ => 0) m) with 0 by (clear; induction m; simpl; lia); lia).
    apply total_le. intros s I. assert (V := S s I).
    assert (A := price_more _ _ V _ (answer_legal _ _ t s T)).
    assert (B : outside (labels t) (more s) <= outside [answer t s] (more s)).
    { apply outside_mono; [apply (more_nonneg _ _ V)|]. intros place. rewrite has_one. intros E.
      apply Nat.eqb_eq in E. subst. apply existsb_exists. exists (answer t s). split; [apply answer_in|].
      apply Nat.eqb_refl. }
    lia. }
  assert (Q : spread (label_count (n_labels r) d) (joined more m []) <= outside (labels t) (joined more m [])).
  { unfold spread, label_count. destruct (Z.of_nat (n_labels r) <=? 2 ^ Z.of_nat d).
    - rewrite outside_joined. cbn [outside].
      assert (0 <= total (fun s => outside (labels t) (more s)) m).
      { apply total_nonneg. intros s I. apply outside_nonneg, (more_nonneg _ _ (S s I)). }
      lia.
    - assert (N := least_sums_length (repeat 0 (Datatypes.S (2 ^ d))) (joined more m [])).
      rewrite repeat_length in N.
      rewrite last_nth by (intros E; rewrite E in N; discriminate).
      rewrite N. replace (Datatypes.S (2 ^ d) - 1)%nat with (2 ^ d)%nat by lia.
      apply least_sums_le; [|lia]. assert (L := labels_length t).
      assert (2 ^ levels t <= 2 ^ d)%nat by (apply Nat.pow_le_mono_r; lia). lia. }
  lia.
Qed.

(** * Along an order *)

(** Something holds of the first samples of an order and the entries of a list, one after the other. *)
Fixpoint along (P : list sample -> Z -> Prop) (before rest : list sample) (bs : list Z) {struct bs} : Prop :=
  match bs with
  | [] => False
  | b :: bs' => P before b /\ match rest with [] => True | s :: rest' => along P (before ++ [s]) rest' bs' end
  end.

Lemma along_nth P : forall rest before bs, along P before rest bs ->
  forall l1 l2, rest = l1 ++ l2 -> P (before ++ l1) (nth (length l1) bs 0).
Proof.
  induction rest as [|s rest IH]; intros before bs A l1 l2 E; destruct bs as [|b bs]; simpl in A; try tauto;
    destruct l1 as [|x l1]; simpl in E; try discriminate.
  - rewrite app_nil_r. tauto.
  - rewrite app_nil_r. tauto.
  - injection E as -> E. destruct A as [_ A]. specialize (IH _ _ A l1 l2 E). rewrite <- app_assoc in IH. exact IH.
Qed.

Lemma joined_snoc what m s : joined what (m ++ [s]) [] = add (joined what m []) (what s).
Proof. unfold joined. rewrite fold_left_app. reflexivity. Qed.

(** What a walk knows: some first samples are solved, or there are none; the others joined since. *)
Definition walked (d : nat) (l : list sample) (before surely : Z) (v : list Z) : Prop :=
  exists base m, l = base ++ m /\ v = joined more m [] /\ surely = total sure m /\
    ((base = [] /\ before = 0) \/ (leaf_size r = 1%nat /\ base <> [] /\ bounds r d base before)).

Lemma grown_bounds d l before surely v : all_sound r l -> walked d l before surely v ->
  bounds r d l (before + surely + spread (label_count (n_labels r) d) v).
Proof.
  intros S (base & m & -> & -> & -> & K). unfold all_sound in S. apply Forall_app in S. destruct S as [_ S].
  assert (G := spread_spec d m S). rewrite <- Z.add_assoc. destruct K as [[-> ->]|(L1 & N & B)].
  - rewrite Z.add_0_l. simpl. apply growing_from_none; auto.
  - apply growing; auto.
Qed.

Lemma grow_along d bound_of_all : forall rest known l now before surely v,
  all_sound r (l ++ rest) -> bounds r d l now -> walked d l before surely v ->
  (forall l1 l2, rest = l1 ++ l2 -> l1 <> [] -> l2 <> [] -> bounds r d (l ++ l1) (nth (length l1 - 1) known 0)) ->
  (rest <> [] -> bounds r d (l ++ rest) bound_of_all) ->
  along (bounds r d) l rest
    (grow (label_count (n_labels r) d) (Nat.eqb (leaf_size r) 1) bound_of_all rest known now before surely v).
Proof.
  induction rest as [|s rest IH]; intros known l now before surely v S N W K A; [simpl; auto|].
  cbn [grow along]. split; [exact N|].
  set (own := match rest with [] => bound_of_all | _ => match known with [] => 0 | b :: _ => b end end).
  assert (O : bounds r d (l ++ [s]) own).
  { subst own. destruct rest as [|s' rest]; [apply A; discriminate|].
    assert (H := K [s] (s' :: rest) eq_refl). simpl in H. destruct known; apply H; discriminate. }
  assert (S' : all_sound r ((l ++ [s]) ++ rest)) by (rewrite <- app_assoc; exact S).
  assert (S1 : all_sound r (l ++ [s])) by (unfold all_sound in *; apply Forall_app in S'; tauto).
  assert (W' : walked d (l ++ [s]) before (surely + sure s) (add v (more s))).
  { destruct W as (base & m & -> & -> & -> & D). exists base, (m ++ [s]).
    rewrite app_assoc, joined_snoc, total_app. simpl. repeat split; auto. lia. }
  assert (G := grown_bounds _ _ _ _ _ S1 W').
  assert (K' : forall l1 l2, rest = l1 ++ l2 -> l1 <> [] -> l2 <> [] ->
    bounds r d ((l ++ [s]) ++ l1) (nth (length l1 - 1) (tl known) 0)).
  { intros l1 l2 E N1 N2. rewrite <- app_assoc. destruct l1 as [|x l1]; [congruence|].
    assert (H := K (s :: x :: l1) l2). cbn [length] in *.
    replace (Datatypes.S (length l1) - 1)%nat with (length l1) by lia.
    replace (Datatypes.S (Datatypes.S (length l1)) - 1)%nat with (Datatypes.S (length l1)) in H by lia.
    assert (T : nth (length l1) (tl known) 0 = nth (Datatypes.S (length l1)) known 0)
      by (destruct known; [rewrite !nth_nil; reflexivity|reflexivity]).
    rewrite T. apply H; [rewrite E; reflexivity|discriminate|exact N2]. }
  assert (A' : rest <> [] -> bounds r d ((l ++ [s]) ++ rest) bound_of_all)
    by (intros _; rewrite <- app_assoc; apply A; discriminate).
  destruct (Nat.eqb_spec (leaf_size r) 1) as [L1|L1]; simpl andb.
  - destruct (_ <? own).
    + apply IH; auto. exists (l ++ [s]), []. rewrite app_nil_r. repeat split; auto. right.
      repeat split; auto. destruct l; discriminate.
    + apply IH; auto. apply bounds_max; auto.
  - apply IH; auto. apply bounds_max; auto.
Qed.

Lemma shrink_along d : forall rest l bs, all_sound r rest -> along (bounds r d) l rest bs ->
  along (bounds r d) l rest (shrink rest bs).
Proof.
  induction rest as [|s rest IH]; intros l bs S A; destruct bs as [|b bs]; simpl in A; try tauto.
  - simpl. exact A.
  - destruct A as [B A]. inversion S as [|? ? S0 S1]; subst. specialize (IH _ _ S1 A).
    simpl shrink. revert IH. destruct (shrink rest bs) as [|next others]; intros IH; [contradiction IH|].
    split; [|exact IH]. assert (N : bounds r d (l ++ [s]) next) by exact (proj1 IH).
    apply bounds_max; [exact B|].
    assert (H := shrinking r d l [s] next). simpl in H. replace (worst s + 0) with (worst s) in H by lia.
    apply H; [constructor; [exact S0|constructor]|exact N].
Qed.

Theorem side_along d order known bound_of_all : all_sound r order ->
  (forall l1 l2, order = l1 ++ l2 -> l1 <> [] -> l2 <> [] -> bounds r d l1 (nth (length l1 - 1) known 0)) ->
  bounds r d order bound_of_all ->
  along (bounds r d) [] order
    (side (label_count (n_labels r) d) (Nat.eqb (leaf_size r) 1) order known bound_of_all).
Proof.
  intros S K A. unfold side. apply shrink_along; [exact S|]. apply grow_along; auto.
  - apply bounds_zero; [exact penalty_nonneg|]. constructor.
  - exists [], []. repeat split. left. auto.
Qed.

End Rules.

Lemma grow_length count may all : forall rest known now before surely v,
  length (grow count may all rest known now before surely v) = S (length rest).
Proof.
  induction rest as [|s rest IH]; intros; [reflexivity|]. cbn [grow length]. f_equal.
  match goal with |- length (if ?c then _ else _) = _ => destruct c end; apply IH.
Qed.

Lemma shrink_length : forall rest bs, length (shrink rest bs) = length bs.
Proof.
  induction rest as [|s rest IH]; intros [|b bs]; simpl; auto. specialize (IH bs).
  destruct (shrink rest bs); simpl in *; congruence.
Qed.

Lemma side_length count may order known all : length (side count may order known all) = S (length order).
Proof. unfold side. rewrite shrink_length. apply grow_length. Qed.
