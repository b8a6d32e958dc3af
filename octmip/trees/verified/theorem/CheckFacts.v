(** The first and the last check of a node: no cut of its columns costs less than its bound. *)

From Coq Require Import ZArith List Bool Permutation Sorting.Sorted Lia Arith.
Import ListNotations.
From octmip Require Import Samples Sums Trees Inequalities Stumps BlockFacts StumpFacts Sides SideFacts Checker.
From octmip Require Import ColumnFacts.
Open Scope Z_scope.
Local Arguments Z.add : simpl never.
Local Arguments Z.sub : simpl never.
Local Arguments Z.mul : simpl never.

Lemma rev'_rev (A : Type) (l : list A) : rev' l = rev l.
Proof. unfold rev'. symmetry. apply rev_alt. Qed.

Section Rules.
Variable r : rules.
Hypothesis penalty_nonneg : 0 <= penalty r.
Hypothesis leaf_size_pos : (1 <= leaf_size r)%nat.

Fixpoint last_key (c : nat) (last : option Z) (l : list sample) : option Z :=
  match l with [] => last | s :: l' => last_key c (Some (key c s)) l' end.

Lemma last_key_snoc c : forall l last x, last_key c last (l ++ [x]) = Some (key c x).
Proof. induction l; simpl; auto. Qed.

Lemma check_cuts_spec line c bound n : forall rest place last left right v,
  check_cuts r line c bound n place last rest left right = Ok v ->
  (length rest < length left)%nat -> (length rest < length right)%nat ->
  forall l1 s l2 k, rest = l1 ++ s :: l2 -> last_key c last l1 = Some k -> k <> key c s ->
  Z.of_nat (leaf_size r) <= place + Z.of_nat (length l1) <= n - Z.of_nat (leaf_size r) ->
  bound <= nth (length l1) left 0 + nth (length l1) right 0 + penalty r.
Proof.
  induction rest as [|s' rest IH]; intros place last left right v C LL LR l1 s l2 k E K N W.
  - destruct l1; discriminate.
  - destruct left as [|a left]; [simpl in LL; lia|]. destruct right as [|b right]; [simpl in LR; lia|].
    simpl in C, LL, LR.
    destruct l1 as [|x l1]; simpl in E; injection E as -> ->.
    + simpl in K, W. subst last. simpl nth.
      match type of C with (if ?a && ?b && ?c && ?d then _ else _) = _ =>
        assert (A1 : a = true) by (apply Z.leb_le; lia); assert (A2 : b = true) by (apply Z.leb_le; lia);
        assert (A3 : c = true) by (apply negb_true_iff, Z.eqb_neq, N); rewrite A1, A2, A3 in C end.
      simpl in C. destruct (Z.ltb_spec (a + b + penalty r) bound); [discriminate|lia].
    + match type of C with (if ?a then _ else _) = _ => destruct a; [discriminate|] end.
      simpl nth. eapply IH; eauto; try lia. cbn [length] in W. lia.
Qed.

Lemma check_column_spec line d bound all c v samples :
  all_sound r samples -> is_column r d samples c -> bounds r d samples all ->
  check_column r line (S d) bound all c = Ok v ->
  forall left edge right, is_cut (index c) (order c) left edge right ->
  (leaf_size r <= length left)%nat -> (leaf_size r <= length right)%nat ->
  exists b1 b2, bounds r d left b1 /\ bounds r d right b2 /\ bound <= penalty r + b1 + b2.
Proof.
  intros S [[P SS] [L SV]] A C left edge right CUT WL WR. unfold check_column in C.
  rewrite !rev'_rev in C. simpl pred in C. rewrite total_one in C.
  set (ls := side _ _ _ (order c) _ _) in C. set (rs := side _ _ _ (rev (order c)) _ _) in C.
  assert (So : all_sound r (order c)) by (eapply sound_perm; eauto).
  assert (Sr : all_sound r (rev (order c))) by (eapply sound_perm; [apply Permutation_rev|exact So]).
  assert (AL : along (bounds r d) [] (order c) ls).
  { apply side_along; auto; [|eapply bounds_perm; eauto].
    intros l1 l2 E N1 N2. change 0 with (fst (0, 0)). rewrite map_nth. apply (SV l1 l2); auto. }
  assert (AR : along (bounds r d) [] (rev (order c)) rs).
  { apply side_along; auto; [|eapply bounds_perm; [|exact A]; eapply Permutation_trans;
    [exact P|apply Permutation_rev]].
    intros l1 l2 E N1 N2. assert (E' : order c = rev l2 ++ rev l1)
      by (rewrite <- rev_app_distr, <- E, rev_involutive; reflexivity).
    destruct (SV (rev l2) (rev l1) E') as [_ B].
    { intros Z0. apply N2. rewrite <- (rev_involutive l2), Z0. reflexivity. }
    { intros Z0. apply N1. rewrite <- (rev_involutive l1), Z0. reflexivity. }
    eapply bounds_perm; [apply Permutation_sym, Permutation_rev|].
    assert (LE : length (order c) = (length l1 + length l2)%nat)
      by (rewrite E', app_length, !rev_length; lia).
    assert (0 < length l1)%nat by (destruct l1; [congruence|simpl; lia]).
    assert (0 < length l2)%nat by (destruct l2; [congruence|simpl; lia]).
    rewrite rev_nth by (rewrite map_length; lia). rewrite map_length, L.
    rewrite rev_length in B.
    replace (pred (length (order c)) - Datatypes.S (length l1 - 1))%nat with (length l2 - 1)%nat by lia.
    change 0 with (snd (0, 0)). rewrite map_nth. exact B. }
  destruct CUT as (E & (l & x & EL & K) & (s & l2 & ER & N)).
  assert (B1 := along_nth _ _ _ _ AL left right E). simpl in B1.
  assert (E' : rev (order c) = rev right ++ rev left) by (rewrite E, rev_app_distr; reflexivity).
  assert (B2 := along_nth _ _ _ _ AR _ _ E'). simpl in B2. rewrite rev_length in B2.
  assert (LS : length ls = Datatypes.S (length (order c))) by apply side_length.
  assert (LRS : length rs = Datatypes.S (length (order c))) by (unfold rs; rewrite side_length,
    rev_length; reflexivity).
  exists (nth (length left) ls 0), (nth (length right) rs 0). split; [exact B1|].
  split; [eapply bounds_perm; [apply Permutation_sym, Permutation_rev|exact B2]|].
  assert (LO : length (order c) = (length left + length right)%nat) by (rewrite E, app_length; reflexivity).
  assert (H := check_cuts_spec _ _ _ _ _ _ _ _ _ _ C).
  assert (Q : bound <= nth (length left) ls 0 + nth (length left) (rev rs) 0 + penalty r).
  { apply (H ltac:(lia) ltac:(rewrite rev_length; lia) left s l2 edge).
    - rewrite E, ER. reflexivity.
    - rewrite EL, last_key_snoc, K. reflexivity.
    - congruence.
    - lia. }
  rewrite rev_nth in Q by lia. rewrite LRS, LO in Q.
  replace (Datatypes.S (length left + length right) - Datatypes.S (length left))%nat with (length right) in Q by lia.
    lia.
Qed.

Lemma check_columns_spec line depth bound all v : forall cs, check_columns r line depth bound all cs = Ok v ->
  v = bound /\ forall c, In c cs -> exists v', check_column r line depth bound all c = Ok v'.
Proof.
  induction cs as [|c cs IH]; simpl; intros H; [injection H as <-; split; [auto|tauto]|].
  destruct (check_column r line depth bound all c) as [v'|] eqn:E; [|discriminate].
  destruct (IH H) as [V I]. split; [exact V|]. intros c' [<-|J]; eauto.
Qed.

(** A threshold that leaves samples on both sides is a cut. *)
Lemma threshold_cut c th order : StronglySorted (key_le c) order -> lower c th order <> [] -> upper c th order <> [] ->
  exists edge, is_cut c order (lower c th order) edge (upper c th order).
Proof.
  intros SS NL NU. destruct (exists_last NL) as (l & x & E). exists (key c x). split; [apply sorted_parts, SS|].
  split; [exists l, x; auto|]. destruct (upper c th order) as [|s u] eqn:U; [congruence|]. exists s, u.
    split; [reflexivity|].
  assert (A : key c x <= th) by (apply (lower_keys c th order); rewrite E; apply in_elt).
  assert (B : th < key c s) by (apply (upper_keys c th order); rewrite U; simpl; auto). lia.
Qed.

Lemma columns_cuts line d bound all v samples cs :
  all_sound r samples -> are_columns r d samples cs -> bounds r d samples all ->
  check_columns r line (S d) bound all cs = Ok v -> cuts_bound r d samples bound.
Proof.
  intros S [F C] A H c th R W1 W2. destruct (check_columns_spec _ _ _ _ _ _ H) as [_ I].
  destruct (C c R) as (col & J & E). destruct (I col J) as (v' & V). rewrite Forall_forall in F.
  assert (COL := F col J). destruct COL as [[P SS] SV]. rewrite E in SS.
  assert (PL : Permutation (lower c th (order col)) (lower c th samples)) by (apply Permutation_sym, filter_perm, P).
  assert (PU : Permutation (upper c th (order col)) (upper c th samples)) by (apply Permutation_sym, filter_perm, P).
  assert (NL := Permutation_length PL). assert (NU := Permutation_length PU).
  destruct (threshold_cut c th (order col) SS) as (edge & CUT);
    [intros Z0; rewrite Z0 in NL; simpl in NL; lia|intros Z0; rewrite Z0 in NU; simpl in NU; lia|].
  rewrite <- E in CUT at 1.
  destruct (check_column_spec _ _ _ _ _ _ _ S (F col J) A V _ _ _ CUT) as (b1 & b2 & B1 & B2 & B); [lia|lia|].
  exists b1, b2. split; [eapply bounds_perm; eauto|]. split; [eapply bounds_perm; eauto|exact B].
Qed.

End Rules.
