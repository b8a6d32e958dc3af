(** The bounds of the sides of cuts are bounds: growing and shrinking along an order. *)

From Coq Require Import ZArith List Bool Permutation Lia Arith.
Import ListNotations.
From octmip Require Import Samples Sums Trees Inequalities Sides SpreadFacts.
Open Scope Z_scope.
Local Arguments Z.add : simpl never.
Local Arguments Z.sub : simpl never.
Local Arguments Z.mul : simpl never.

Section Rules.
Variable r : rules.
Hypothesis penalty_nonneg : 0 <= penalty r.

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
Definition walked (d : nat) (l : list sample) (before surely : Z) (v by_set : list Z) : Prop :=
  exists base m, l = base ++ m /\ v = joined more m [] /\ surely = total sure m /\
    by_set = joined (set_costs (label_sets (with_sets r) (n_labels r) d)) m [] /\
    ((base = [] /\ before = 0) \/ (leaf_size r = 1%nat /\ base <> [] /\ bounds r d base before)).

Lemma grown_bounds d l before surely v by_set : all_sound r l -> walked d l before surely v by_set ->
  bounds r d l (before + Z.max (surely + spread (label_count (n_labels r) d) v) (or_zero (least by_set))).
Proof.
  intros S (base & m & -> & -> & -> & -> & K). unfold all_sound in S. apply Forall_app in S. destruct S as [_ S].
  assert (G := spreads_max r _ _ _ _ (spread_spec r d m S) (sets_spec r d m (with_sets r) S)).
  destruct K as [[-> ->]|(L1 & N & B)].
  - rewrite Z.add_0_l. simpl. apply growing_from_none; auto.
  - apply growing; auto.
Qed.

Lemma grow_along d bound_of_all : forall rest known l now before surely v by_set,
  all_sound r (l ++ rest) -> bounds r d l now -> walked d l before surely v by_set ->
  (forall l1 l2, rest = l1 ++ l2 -> l1 <> [] -> l2 <> [] -> bounds r d (l ++ l1) (nth (length l1 - 1) known 0)) ->
  (rest <> [] -> bounds r d (l ++ rest) bound_of_all) ->
  along (bounds r d) l rest
    (grow (label_count (n_labels r) d) (label_sets (with_sets r) (n_labels r) d) (Nat.eqb (leaf_size r) 1) bound_of_all
      rest known now before surely v by_set).
Proof.
  induction rest as [|s rest IH]; intros known l now before surely v by_set S N W K A; [simpl; auto|].
  cbn [grow along]. split; [exact N|].
  set (own := match rest with [] => bound_of_all | _ => match known with [] => 0 | b :: _ => b end end).
  assert (O : bounds r d (l ++ [s]) own).
  { subst own. destruct rest as [|s' rest]; [apply A; discriminate|].
    assert (H := K [s] (s' :: rest) eq_refl). simpl in H. destruct known; apply H; discriminate. }
  assert (S' : all_sound r ((l ++ [s]) ++ rest)) by (rewrite <- app_assoc; exact S).
  assert (S1 : all_sound r (l ++ [s])) by (unfold all_sound in *; apply Forall_app in S'; tauto).
  assert (W' : walked d (l ++ [s]) before (surely + sure s) (add v (more s))
    (add by_set (set_costs (label_sets (with_sets r) (n_labels r) d) s))).
  { destruct W as (base & m & -> & -> & -> & -> & D). exists base, (m ++ [s]).
    rewrite app_assoc, !joined_snoc, total_app. simpl. repeat split; auto. lia. }
  assert (G := grown_bounds _ _ _ _ _ _ S1 W').
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
    (side (label_count (n_labels r) d) (label_sets (with_sets r) (n_labels r) d) (Nat.eqb (leaf_size r) 1) order known
      bound_of_all).
Proof.
  intros S K A. unfold side. apply shrink_along; [exact S|]. apply grow_along; auto.
  - apply bounds_zero; [exact penalty_nonneg|]. constructor.
  - exists [], []. repeat split. left. auto.
Qed.

End Rules.

Lemma grow_length count sets may all : forall rest known now before surely v by_set,
  length (grow count sets may all rest known now before surely v by_set) = S (length rest).
Proof.
  induction rest as [|s rest IH]; intros; [reflexivity|]. cbn [grow length]. f_equal.
  match goal with |- length (if ?c then _ else _) = _ => destruct c end; apply IH.
Qed.

Lemma shrink_length : forall rest bs, length (shrink rest bs) = length bs.
Proof.
  induction rest as [|s rest IH]; intros [|b bs]; simpl; auto. specialize (IH bs).
  destruct (shrink rest bs); simpl in *; congruence.
Qed.

Lemma side_length count sets may order known all : length (side count sets may order known all) = S (length order).
Proof. unfold side. rewrite shrink_length. apply grow_length. Qed.
