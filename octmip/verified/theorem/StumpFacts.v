(** What is counted of the cheapest trees of one split is a bound of them. *)

From Coq Require Import ZArith List Bool Permutation Sorting.Sorted Lia Arith.
Import ListNotations.
From octmip Require Import Samples Sums Trees Inequalities Stumps ScanFacts.
Open Scope Z_scope.
Local Arguments Z.add : simpl never.
Local Arguments Z.sub : simpl never.
Local Arguments Z.mul : simpl never.

(** * Bounds *)

Section Rules.
Variable r : rules.
Hypothesis penalty_nonneg : 0 <= penalty r.
Hypothesis leaf_size_pos : (1 <= leaf_size r)%nat.

(** Orders of all columns that may be read. *)
Definition all_orders (samples : list sample) (orders : list (nat * list sample)) : Prop :=
  Forall (fun o => Permutation samples (snd o) /\ StronglySorted (key_le (fst o)) (snd o)) orders /\
  forall c, may_read r c = true -> exists l, In (c, l) orders.

Lemma paid_leaf a l : all_sound r l -> (a < n_labels r)%nat ->
  paid (Leaf a) l = total worst l - nth a (joined gains l []) 0.
Proof.
  intros S A. rewrite nth_joined, nth_nil. unfold paid. simpl.
  replace (0 + total (fun s => nth a (gains s) 0) l) with (total (fun s => gain a s) l) by (unfold gain; lia).
  rewrite <- total_minus. apply total_ext. intros s I. unfold all_sound in S. rewrite Forall_forall in S.
  apply (price_gain _ _ (S s I)). exact A.
Qed.

Lemma leaf_cost l b : all_sound r l -> b <= total worst l - top (joined gains l []) -> leaf_bounds r l b.
Proof.
  intros S B a A. rewrite paid_leaf by auto. assert (H := nth_le_top (joined gains l []) a). lia.
Qed.

Lemma bounds_of_leaf l b : leaf_bounds r l b -> bounds r 0 l b.
Proof.
  intros B t T D F. destruct t; simpl in D; [|lia]. unfold cost. simpl n_splits. rewrite Z.mul_0_r.
  apply B. destruct T as [_ T]. inversion T; auto.
Qed.

Lemma joined_nonneg l i : all_sound r l -> 0 <= nth i (joined gains l []) 0.
Proof.
  intros S. rewrite nth_joined, nth_nil.
  assert (0 <= total (fun s => nth i (gains s) 0) l); [|lia].
  apply total_nonneg. intros s I. unfold all_sound in S. rewrite Forall_forall in S.
  apply (gain_range _ _ (S s I)).
Qed.

Lemma saving_of_parts l low up : all_sound r l -> Permutation l (low ++ up) ->
  top (joined gains low []) + top (joined gains up []) <= saving (joined gains l []) (joined gains low []).
Proof.
  intros S P. unfold saving. apply Z.add_le_mono_l.
  assert (S' : all_sound r (low ++ up)) by (unfold all_sound in *; eapply Permutation_Forall; eauto).
  assert (SL : all_sound r low) by (unfold all_sound in *; apply Forall_app in S'; tauto).
  assert (SU : all_sound r up) by (unfold all_sound in *; apply Forall_app in S'; tauto).
  assert (E : forall i, nth i (joined gains l []) 0 = nth i (joined gains low []) 0 + nth i (joined gains up []) 0).
  { intros i. rewrite !nth_joined, !nth_nil. rewrite (total_perm _ _ _ P), total_app. lia. }
  apply top_le; [apply top_gap_nonneg|]. intros i.
  destruct (Nat.lt_ge_cases i (length (joined gains l []))) as [L|L].
  - assert (H := nth_le_top_gap (joined gains l []) (joined gains low []) i L). specialize (E i). lia.
  - specialize (E i). rewrite nth_overflow in E by lia. assert (A := joined_nonneg low i SL).
    assert (B := joined_nonneg up i SU). assert (C := top_gap_nonneg (joined gains l []) (joined gains low [])). lia.
Qed.

Lemma sound_perm l l' : Permutation l l' -> all_sound r l -> all_sound r l'.
Proof. intros P S. unfold all_sound in *. eapply Permutation_Forall; eauto. Qed.

Theorem one_part l orders most : all_sound r l -> all_orders l orders ->
  let p := Part (joined gains l []) (total reach l) (Z.of_nat (length l)) (Z.of_nat (leaf_size r)) in
  top (joined gains l []) + penalty r <= most -> (forall c o, In (c, o) orders -> is_cap p c o most) ->
  bounds r 1 l (total worst l + penalty r - most).
Proof.
  intros S [O R] p M H.
  apply node.
  - apply leaf_cost; auto. lia.
  - intros c th C W1 W2. destruct (R c C) as (o & I).
    rewrite Forall_forall in O. destruct (O _ I) as [P SS]. simpl in P, SS.
    assert (PL : Permutation (lower c th o) (lower c th l)) by (apply Permutation_sym, filter_perm, P).
    assert (PU : Permutation (upper c th o) (upper c th l)) by (apply Permutation_sym, filter_perm, P).
    assert (E := sorted_parts c th o SS).
    assert (So : all_sound r o) by (eapply sound_perm; eauto).
    assert (SP : all_sound r (lower c th o ++ upper c th o)) by (rewrite <- E; exact So).
    assert (SL : all_sound r (lower c th o)) by (unfold all_sound in *; apply Forall_app in SP; tauto).
    assert (SU : all_sound r (upper c th o)) by (unfold all_sound in *; apply Forall_app in SP; tauto).
    assert (NL := Permutation_length PL). assert (NU := Permutation_length PU).
    assert (NE := Permutation_length P). rewrite E, app_length in NE.
    exists (total worst (lower c th o) - top (joined gains (lower c th o) [])),
           (total worst (upper c th o) - top (joined gains (upper c th o) [])).
    split; [eapply bounds_perm; [exact PL|]; apply bounds_of_leaf, leaf_cost; [exact SL|lia]|].
    split; [eapply bounds_perm; [exact PU|]; apply bounds_of_leaf, leaf_cost; [exact SU|lia]|].
    assert (SV := saving_of_parts l (lower c th o) (upper c th o) S).
    assert (P' : Permutation l (lower c th o ++ upper c th o)) by (rewrite <- E; exact P).
    specialize (SV P').
    assert (W : total worst l = total worst (lower c th o) + total worst (upper c th o))
      by (rewrite (total_perm _ _ _ P'), total_app; reflexivity).
    destruct (exists_last (l := lower c th o)) as (l1 & x & EL); [intros Z0; rewrite Z0 in NL; simpl in NL; lia|].
    destruct (upper c th o) as [|s l2] eqn:EU; [simpl in NU; lia|].
    assert (X := lower_keys c th o x). rewrite EL in X. specialize (X (in_elt _ _ _)).
    assert (Y := upper_keys c th o s). rewrite EU in Y. specialize (Y (or_introl eq_refl)).
    assert (F : saving (all_gains p) (joined gains (l1 ++ [x]) []) <= most).
    { apply (H c o I l1 x s l2).
      - rewrite E at 1. rewrite EL, <- app_assoc. reflexivity.
      - lia.
      - rewrite <- EL. simpl. simpl length in NU, NE. lia. }
    rewrite <- EL in F. simpl all_gains in F. lia.
Qed.

Definition orders_of (f : list sample -> list sample) (orders : list (nat * list sample)) :=
  map (fun o => (fst o, f (snd o))) orders.

Lemma all_orders_part keep l orders : all_orders l orders -> all_orders (filter keep l) (orders_of (filter keep)
  orders).
Proof.
  intros [O R]. split.
  - rewrite Forall_forall in *. intros o I. apply in_map_iff in I. destruct I as (o' & <- & I). simpl.
    destruct (O o' I). split; [apply filter_perm; auto|apply sorted_filter; auto].
  - intros c C. destruct (R c C) as (o & I). exists (filter keep o). apply in_map_iff. exists (c, o). auto.
Qed.

Lemma sound_filter keep l : all_sound r l -> all_sound r (filter keep l).
Proof.
  unfold all_sound. rewrite !Forall_forall. intros S s I. apply filter_In in I. apply S. tauto.
Qed.

Lemma parts_of_spec place is_low samples : all_sound r samples -> forall edges previous,
  nested is_low previous edges ->
  Forall2 (fun edge c => let kept := part_of place edge is_low samples in
    its_edge c = edge /\ its_worst c = total worst kept /\ found c = top (joined gains kept []) + penalty r /\
    its_part c = Part (joined gains kept []) (total reach kept) (Z.of_nat (length kept)) (Z.of_nat (leaf_size r))) edges
    (parts_of (penalty r) (Z.of_nat (leaf_size r)) place is_low edges (so_far place is_low previous samples)).
Proof.
  intros S. induction edges as [|edge edges IH]; intros previous N; cbn [parts_of]; [constructor|].
  destruct N as [N0 N]. rewrite so_far_part by exact N0. rewrite sums_spec, !Z.add_0_l. constructor.
  - simpl. auto.
  - apply (IH (Some edge)), N.
Qed.

(** All parts that are counted are bounded. *)
Theorem stumps_spec place is_low samples orders edges : all_sound r samples -> all_orders samples orders ->
  Forall2 (fun edge b => bounds r 1 (part_of place edge is_low samples) b) edges
    (stumps (penalty r) (Z.of_nat (leaf_size r)) place is_low edges samples
      (map (fun o => run_of place (fst o) (snd o)) orders)).
Proof.
  intros S O. unfold stumps. destruct (are_nested is_low edges) eqn:N.
  - apply are_nested_spec in N.
    assert (OS : Forall (fun o => Forall (sound (n_labels r)) (snd o)) orders).
    { destruct O as [O _]. rewrite Forall_forall in O |- *. intros o I.
      apply (sound_perm samples (snd o)); [apply O, I|exact S]. }
    assert (A := parts_of_spec place is_low samples S edges None N). simpl in A.
    set (parts := parts_of _ _ place is_low edges samples) in *.
    assert (E : map its_edge parts = edges).
    { clear -A. induction A as [|e c es cs (E & _) F IH]; simpl; congruence. }
    assert (DS : Forall (fun o => Forall (fun b => describes place is_low b (snd o)) parts) orders).
    { destruct O as [O _]. rewrite Forall_forall in O |- *. intros o I. destruct (O o I) as [P _]. clear -A P.
      induction A as [|e c es cs (E1 & _ & _ & E4) F IH]; constructor; auto.
      unfold describes. rewrite E4, E1. simpl. apply Z.eq_le_incl, total_perm, filter_perm, Permutation_sym, P. }
    assert (B := fold_parts_spec (n_labels r) place is_low orders parts OS ltac:(rewrite E; exact N) DS).
    set (parts' := fold_left _ _ _) in *. clearbody parts'. clear E N DS. clearbody parts.
    revert parts' B. induction A as [|e c es cs (E1 & E2 & E3 & E4) F IH]; intros parts' B;
      inversion B as [|? c' ? cs' Q T]; subst;
      simpl; constructor; [|apply IH, T].
    destruct Q as (G1 & G2 & G3 & M & H). rewrite G3, E2.
    apply (one_part _ (orders_of (part_of place (its_edge c) is_low) orders)).
    + apply sound_filter, S.
    + apply all_orders_part, O.
    + rewrite <- E3. exact M.
    + intros i o I. apply in_map_iff in I. destruct I as ([i' l] & X & I). injection X as <- <-.
      specialize (H i' l I). unfold caps in H. rewrite E4 in H. exact H.
  - clear N. induction edges as [|edge edges IH]; simpl; constructor; auto.
    apply bounds_zero; [exact penalty_nonneg|]. apply sound_filter, S.
Qed.

End Rules.
