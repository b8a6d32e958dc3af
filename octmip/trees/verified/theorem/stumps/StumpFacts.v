(** What is counted of the cheapest trees of one split is a bound of them. *)

From Coq Require Import ZArith List Bool Permutation Sorting.Sorted Lia Arith.
Import ListNotations.
From octmip Require Import Samples Sums PackFacts Trees Inequalities Stumps BlockFacts ScanFacts.
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
  top (joined gains l []) + penalty r <= most ->
  (forall c o, In (c, o) orders ->
    is_cap (joined gains l []) (total (fun _ => 1) l) (Z.of_nat (leaf_size r)) c o most) ->
  bounds r 1 l (total worst l + penalty r - most).
Proof.
  intros S [O R] M H.
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
    assert (F : saving (joined gains l []) (joined gains (l1 ++ [x]) []) <= most).
    { apply (H c o I l1 x s l2).
      - rewrite E at 1. rewrite EL, <- app_assoc. reflexivity.
      - lia.
      - rewrite <- EL, !total_one. simpl length in NU, NE. lia. }
    rewrite <- EL in F. lia.
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

(** * Both sides of the edges *)

Section Sides.
Variable w : Z.
Hypothesis w_nonneg : 0 <= w.
Variable place : sample -> Z.
Variable samples : list sample.
Hypothesis samples_pack : Forall (packs (n_labels r) w) samples.
Hypothesis samples_fit : total reach samples < 2 ^ w.

Definition part_with (its_gains count : Z) : part :=
  Part its_gains count (Z.of_nat (leaf_size r)) (n_labels r) w (2 ^ w - 1).

(** What is known of a side when some orders are counted. *)
Record side_is (edge : Z) (is_low : bool) (seen : list (nat * list sample)) (s : side_sums) : Prop := {
  part_is : its_part s = part_with (total packed (part_of place edge is_low samples))
    (total (fun _ => 1) (part_of place edge is_low samples));
  worst_is : its_worst s = total worst (part_of place edge is_low samples);
  found_leaf : top (joined gains (part_of place edge is_low samples) []) + penalty r <= found s;
  found_cuts : forall c l, In (c, l) seen ->
    is_cap (joined gains (part_of place edge is_low samples) [])
      (total (fun _ => 1) (part_of place edge is_low samples)) (Z.of_nat (leaf_size r)) c
      (part_of place edge is_low l) (found s)
}.

Lemma part_packs edge is_low l : Forall (packs (n_labels r) w) l ->
  Forall (packs (n_labels r) w) (part_of place edge is_low l).
Proof.
  rewrite !Forall_forall. intros F s I. apply filter_In in I. apply F. tauto.
Qed.

Lemma part_fits edge is_low l : Forall (packs (n_labels r) w) l -> total reach l < 2 ^ w ->
  total reach (part_of place edge is_low l) < 2 ^ w.
Proof.
  intros F R. rewrite (total_sides reach place edge) in R.
  assert (A := reach_nonneg _ _ (packs_sound _ _ _ (part_packs edge true l F))).
  assert (B := reach_nonneg _ _ (packs_sound _ _ _ (part_packs edge false l F))). destruct is_low; lia.
Qed.

Lemma sum_below_spec edge : forall l g m c, sum_below edge (map (fun s => (place s, s)) l) g m c =
  let low := part_of place edge true l in (g + total packed low, m + total worst low, c + total (fun _ => 1) low).
Proof.
  unfold part_of. induction l as [|s l IH]; intros g m c; cbn [map sum_below filter]; cbv zeta.
  - simpl. rewrite !Z.add_0_r. reflexivity.
  - rewrite !is_in_low. destruct (place s <=? edge); cbn [total]; rewrite IH; cbv zeta; [|reflexivity].
    rewrite <- !Z.add_assoc. reflexivity.
Qed.

Lemma side_of_spec edge is_low :
  let kept := part_of place edge is_low samples in
  side_is edge is_low []
    (side_of (penalty r) (part_with (total packed kept) (total (fun _ => 1) kept)) (total worst kept)).
Proof.
  cbv zeta. constructor; [reflexivity|reflexivity| |intros c l []]. simpl. apply Z.add_le_mono_r.
  assert (H := saved_packed (n_labels r) w w_nonneg (part_of place edge is_low samples) []).
  unfold saved_by. simpl in *. rewrite H; auto using part_packs, part_fits, Z.pow_pos_nonneg.
  - unfold saving. rewrite top_gap_of_none. simpl. lia.
  - apply Z.pow_pos_nonneg; lia.
Qed.

Record cut_is (edge : Z) (seen : list (nat * list sample)) (c : cut_sums) : Prop := {
  edge_is : its_edge c = edge;
  low_is : side_is edge true seen (low c);
  high_is : side_is edge false seen (high c)
}.

Lemma cut_of_spec edge :
  cut_is edge [] (cut_of (penalty r) (Z.of_nat (leaf_size r)) (n_labels r) w (map (fun s => (place s, s)) samples)
    (total packed samples) (total worst samples) (total (fun _ => 1) samples) edge).
Proof.
  unfold cut_of. rewrite sum_below_spec. cbv zeta. rewrite !Z.add_0_l.
  rewrite (total_sides packed place edge samples), (total_sides worst place edge samples),
    (total_sides (fun _ => 1) place edge samples).
  rewrite !(Z.add_comm (total _ (part_of place edge true samples))), !Z.add_simpl_r.
  constructor; [reflexivity|apply side_of_spec|apply side_of_spec].
Qed.

Lemma scan_side_spec edge is_low seen c l blocks ls s : side_is edge is_low seen s -> Permutation samples l ->
  concat ls = l -> Forall2 (is_parted place edge c) blocks ls ->
  side_is edge is_low (seen ++ [(c, l)]) (scan_side edge is_low blocks s).
Proof.
  intros [P W L C] O E B.
  assert (F : fit (n_labels r) w (part_of place edge is_low l)).
  { assert (Q : Forall (packs (n_labels r) w) l) by (eapply Permutation_Forall; eauto).
    assert (T : total reach l < 2 ^ w) by (rewrite <- (total_perm _ _ _ O); exact samples_fit).
    split; [apply part_packs, Q|apply part_fits; assumption]. }
  destruct (scan_start (n_labels r) w w_nonneg (its_part s) (part_of place edge is_low samples)
    (part_packs _ _ _ samples_pack) (part_fits _ _ _ samples_pack samples_fit) ltac:(rewrite P; reflexivity)
    place edge is_low c l blocks ls (found s) E B F) as [M H].
  constructor; simpl; [exact P|exact W|lia|]. intros c' l' I. apply in_app_or in I. destruct I as [I|[I|[]]].
  - specialize (C c' l' I). unfold is_cap in *. intros. eapply Z.le_trans; [|exact M]. eapply C; eauto.
  - injection I as <- <-. rewrite P in H |- *. exact H.
Qed.

Lemma scan_cut_spec edge seen c l cut : cut_is edge seen cut -> Permutation samples l ->
  cut_is edge (seen ++ [(c, l)]) (scan_cut (blocks_of place (keyed c l)) cut).
Proof.
  intros [E L H] P. destruct (blocks_of_spec place c l) as (ls & EL & B).
  assert (B' : Forall2 (is_parted place edge c) (map (fun b => (b, below edge b)) (blocks_of place (keyed c l))) ls).
  { clear -B. induction B as [|b x bs xs I F IH]; constructor; auto. split; [exact I|]. apply (below_spec place c), I. }
  unfold scan_cut. rewrite E.
  constructor; [reflexivity|eapply scan_side_spec; eauto|eapply scan_side_spec; eauto].
Qed.

Lemma fold_cuts : forall (orders seen : list (nat * list sample)) edges cuts,
  Forall (fun o => Permutation samples (snd o)) orders -> Forall2 (fun edge c => cut_is edge seen c) edges cuts ->
  Forall2 (fun edge c => cut_is edge (seen ++ orders) c) edges
    (fold_left (scan_order place) (map (fun o => keyed (fst o) (snd o)) orders) cuts).
Proof.
  induction orders as [|[c l] orders IH]; intros seen edges cuts P F; simpl; [rewrite app_nil_r; exact F|].
  inversion P as [|? ? P0 P1]; subst.
  replace (seen ++ (c, l) :: orders) with ((seen ++ [(c, l)]) ++ orders) by (rewrite <- app_assoc; reflexivity).
  apply IH; [exact P1|]. unfold scan_order. clear IH P P1.
  induction F; simpl; constructor; auto. apply scan_cut_spec; assumption.
Qed.

Lemma side_bound edge is_low orders s : all_sound r samples -> all_orders samples orders ->
  side_is edge is_low orders s ->
  bounds r 1 (part_of place edge is_low samples) (its_worst s + penalty r - found s).
Proof.
  intros S O [P W L C]. rewrite W.
  apply (one_part _ (orders_of (part_of place edge is_low) orders));
    [apply sound_filter, S|apply all_orders_part, O|exact L|].
  intros c o I. apply in_map_iff in I. destruct I as ([c' l] & X & I). injection X as <- <-. apply (C c' l I).
Qed.

End Sides.

Lemma common_width_spec samples w : all_sound r samples -> common_width samples = Some w ->
  0 <= w /\ Forall (packs (n_labels r) w) samples /\ total reach samples < 2 ^ w.
Proof.
  intros S H. unfold common_width in H. destruct samples as [|s samples].
  { assert (E : w = 0) by congruence. subst w. split; [lia|]. split; [constructor|simpl; lia]. }
  destruct (forallb _ _) eqn:F; [|discriminate]. cbn [andb] in H.
  destruct (Z.ltb_spec (total reach (s :: samples)) (2 ^ width s)) as [L|]; [|discriminate]. injection H as <-.
  assert (P : Forall (packs (n_labels r) (width s)) (s :: samples)).
  { rewrite forallb_forall in F. unfold all_sound in S. rewrite Forall_forall in S |- *. intros x I.
    split; [apply S, I|apply Z.eqb_eq, F, I]. }
  split; [|split; [exact P|exact L]]. inversion S as [|? ? S0 _]; subst. apply (width_nonneg _ _ S0).
Qed.

(** All parts that are counted are bounded. *)
Theorem stumps_spec place samples orders edges : all_sound r samples -> all_orders samples orders ->
  Forall2 (fun edge both => bounds r 1 (part_of place edge true samples) (fst both) /\
      bounds r 1 (part_of place edge false samples) (snd both)) edges
    (stumps (penalty r) (Z.of_nat (leaf_size r)) (n_labels r) place edges samples
      (map (fun o => keyed (fst o) (snd o)) orders)).
Proof.
  intros S O. unfold stumps. destruct (common_width samples) as [w|] eqn:CW.
  - destruct (common_width_spec samples w S CW) as (W & P & T).
    assert (OP : Forall (fun o => Permutation samples (snd o)) orders).
    { destruct O as [O _]. eapply Forall_impl; [|exact O]. intros o [Q _]. exact Q. }
    assert (A : Forall2 (fun edge c => cut_is w place samples edge [] c) edges
      (map (cut_of (penalty r) (Z.of_nat (leaf_size r)) (n_labels r) w (map (fun s => (place s, s)) samples)
        (total packed samples) (total worst samples) (total (fun _ => 1) samples)) edges)).
    { clear CW. induction edges; simpl; constructor; auto. apply cut_of_spec; assumption. }
    assert (B := fold_cuts w W place samples P T orders [] edges _ OP A). simpl in B.
    set (cuts := fold_left _ _ _) in *. clearbody cuts. clear A.
    induction B as [|edge c es cs [E L H] F IH]; simpl; constructor; auto.
    simpl. split; apply (side_bound w place samples edge _ orders); assumption.
  - clear CW. induction edges as [|edge edges IH]; simpl; constructor; auto.
    simpl. split; apply bounds_zero; try exact penalty_nonneg; apply sound_filter, S.
Qed.

End Rules.
