(** A scan finds the most that a cut saves: the walk that skips. *)

From Coq Require Import ZArith List Bool Permutation Sorting.Sorted Lia Arith.
Import ListNotations.
From octmip Require Import Samples Sums PackFacts Trees Inequalities Stumps BlockFacts.
Open Scope Z_scope.
Local Arguments Z.add : simpl never.
Local Arguments Z.sub : simpl never.
Local Arguments Z.mul : simpl never.

(** No cut of an order saves more. *)
Definition is_cap (all : list Z) (size leaf : Z) (c : nat) (l : list sample) (most : Z) : Prop :=
  forall l1 x s l2, l = l1 ++ x :: s :: l2 -> key c x <> key c s ->
    leaf <= total (fun _ => 1) (l1 ++ [x]) <= size - leaf -> saving all (joined gains (l1 ++ [x]) []) <= most.

Section Walk.
Variable n : nat.
Variable w : Z.
Hypothesis w_nonneg : 0 <= w.
Variable p : part.
Variable samples : list sample.
Hypothesis samples_pack : Forall (packs n w) samples.
Hypothesis samples_fit : total reach samples < 2 ^ w.
Hypothesis its_part : p = Part (total packed samples) (size p) (leaf p) n w (2 ^ w - 1).
Variable place : sample -> Z.
Variable edge : Z.
Variable is_low : bool.
Variable c : nat.

Definition look (gone : list sample) : Z := saving (joined gains samples []) (joined gains gone []).
(** Samples whose sums fit. *)
Definition fit (l : list sample) : Prop := Forall (packs n w) l /\ total reach l < 2 ^ w.
Definition kept (l : list sample) : list sample := part_of place edge is_low l.

Lemma saved_by_look gone : fit gone -> saved_by p (total packed gone) = look gone.
Proof.
  intros [F R]. unfold saved_by. rewrite its_part. simpl. apply (saved_packed n w w_nonneg); auto.
Qed.

Lemma fit_app l l' : fit (l ++ l') -> fit l /\ Forall (sound n) l'.
Proof.
  intros [F R]. apply Forall_app in F. destruct F as [F F']. rewrite total_app in R.
  assert (P := reach_nonneg n l' (packs_sound n w l' F')). split; [split; [exact F|lia]|].
  apply (packs_sound n w), F'.
Qed.

Lemma look_steps gone l : Forall (sound n) l ->
  look (gone ++ l) <= look gone + total reach l /\ look gone <= look (gone ++ l) + total reach l.
Proof.
  intros S. unfold look.
  replace (joined gains (gone ++ l) []) with (joined gains l (joined gains gone []))
    by (unfold joined; rewrite fold_left_app; reflexivity).
  apply (saving_steps n (joined gains samples []) l (joined gains gone []) S).
Qed.

Definition last_of (last : Z) (l : list sample) : Z := fold_left (fun _ s => key c s) l last.

Lemma scan_spec : forall l last gone slack most, fit (gone ++ kept l) -> look gone + slack <= most ->
  let found := scan p edge is_low (run_of place c l) last (total packed gone) (total (fun _ => 1) gone) slack most in
  most <= found /\ forall l1 s l2, kept l = l1 ++ s :: l2 -> last_of last l1 <> key c s ->
    leaf p <= total (fun _ => 1) (gone ++ l1) <= size p - leaf p -> look (gone ++ l1) <= found.
Proof.
  induction l as [|y l IH]; intros last gone slack most F I; cbv zeta; cbn [run_of scan].
  - split; [lia|]. intros l1 s l2 E. destruct l1; discriminate.
  - unfold kept, part_of in *. cbn [filter] in *. destruct (is_in edge is_low (place y)) eqn:IN; [|apply IH; auto].
    fold (part_of place edge is_low l) in *. fold (kept l) in *.
    assert (EQ : gone ++ y :: kept l = (gone ++ [y]) ++ kept l) by (rewrite <- app_assoc; reflexivity).
    assert (F1 := F). apply fit_app in F1. destruct F1 as [FG FS]. rewrite EQ in F.
    assert (SY : sound n y) by (inversion FS; assumption).
    assert (ST := proj1 (look_steps gone [y] (Forall_cons y SY (Forall_nil _)))). cbn [total] in ST.
    assert (TP : total packed gone + packed y = total packed (gone ++ [y])) by (rewrite total_app; simpl; lia).
    assert (TO : total (fun _ => 1) gone + 1 = total (fun _ => 1) (gone ++ [y])) by (rewrite total_app; simpl; lia).
    assert (H : forall most' slack', most <= most' -> look (gone ++ [y]) + slack' <= most' ->
      (last <> key c y -> leaf p <= total (fun _ => 1) gone <= size p - leaf p -> look gone <= most') ->
      let found := scan p edge is_low (run_of place c l) (key c y) (total packed gone + packed y)
        (total (fun _ => 1) gone + 1) slack' most' in
      most <= found /\ forall l1 s l2, y :: kept l = l1 ++ s :: l2 -> last_of last l1 <> key c s ->
        leaf p <= total (fun _ => 1) (gone ++ l1) <= size p - leaf p -> look (gone ++ l1) <= found).
    { intros most' slack' M I' B. cbv zeta. rewrite TP, TO.
      destruct (IH (key c y) (gone ++ [y]) slack' most' F I') as [M' H']. split; [lia|].
      intros l1 s l2 E K W. destruct l1 as [|z l1]; injection E; intros; subst.
      - rewrite app_nil_r in *. apply Z.le_trans with most'; [apply B; assumption|exact M'].
      - replace (gone ++ z :: l1) with ((gone ++ [z]) ++ l1) in * by (rewrite <- app_assoc; reflexivity).
        apply (H' l1 s l2); auto. }
    destruct (Z.ltb_spec slack 0) as [SL|SL]; cbn [andb].
    + destruct (Z.eqb_spec last (key c y)) as [EK|EK]; cbn [negb].
      * apply H; [lia|lia|congruence].
      * rewrite saved_by_look by exact FG. set (most' := if is_wide p _ then _ else _).
        assert (M : most <= most') by (unfold most'; destruct (is_wide _ _); lia).
        apply H; [exact M|lia|]. intros _ W. unfold most', is_wide.
        assert (A : (leaf p <=? total (fun _ => 1) gone) = true) by (apply Z.leb_le; lia).
        assert (B : (total (fun _ => 1) gone <=? size p - leaf p) = true) by (apply Z.leb_le; lia).
        rewrite A, B. simpl. lia.
    + apply H; [lia|lia|]. intros _ _. lia.
Qed.

Lemma scan_held_spec l gone slack most : fit (gone ++ kept l) -> look gone + slack <= most ->
  let found := scan_held p edge is_low (run_of place c l) (total packed gone) (total (fun _ => 1) gone) slack most in
  most <= found /\ forall l1 x s l2, kept l = l1 ++ x :: s :: l2 -> key c x <> key c s ->
    leaf p <= total (fun _ => 1) (gone ++ l1 ++ [x]) <= size p - leaf p -> look (gone ++ l1 ++ [x]) <= found.
Proof.
  intros F I. cbv zeta. destruct l as [|y l].
  - simpl. split; [lia|]. intros l1 x s l2 E. destruct l1; discriminate.
  - destruct (scan_spec (y :: l) (key c y) gone slack most F I) as [M H]. split; [exact M|].
    intros l1 x s l2 E K W. apply (H (l1 ++ [x]) s l2); [rewrite E, <- app_assoc; reflexivity| |exact W].
    unfold last_of. rewrite fold_left_app. exact K.
Qed.

(** Two samples that follow each other lie in the first list, in the second, or one in each. *)
Lemma neighbours (l1 : list sample) x s l2 : forall k m, k ++ m = l1 ++ x :: s :: l2 ->
  (exists l2', k = l1 ++ x :: s :: l2') \/ (k = l1 ++ [x] /\ m = s :: l2) \/
  (exists l1', l1 = k ++ l1' /\ m = l1' ++ x :: s :: l2).
Proof.
  induction l1 as [|z l1 IH]; intros k m E.
  - destruct k as [|a [|b k]]; simpl in E.
    + right. right. exists []. auto.
    + injection E as -> ->. right. left. auto.
    + injection E as -> -> <-. left. exists k. reflexivity.
  - destruct k as [|a k]; simpl in E.
    + right. right. exists (z :: l1). auto.
    + injection E as -> E. destruct (IH k m E) as [(l2' & ->)|[[-> ->]|(l1' & -> & ->)]].
      * left. exists l2'. reflexivity.
      * right. left. auto.
      * right. right. exists l1'. auto.
Qed.

Definition is_parted (b : block * sums) (l : list sample) : Prop :=
  is_block place c (fst b) l /\ snd b = sums_of (part_of place edge true l).

Theorem scan_blocks_spec : forall blocks ls, Forall2 is_parted blocks ls ->
  forall gone slack most, fit (gone ++ kept (concat ls)) -> look gone + slack <= most ->
  let found := scan_blocks p edge is_low blocks (total packed gone) (total (fun _ => 1) gone) slack most in
  most <= found /\ forall l1 x s l2, kept (concat ls) = l1 ++ x :: s :: l2 -> key c x <> key c s ->
    leaf p <= total (fun _ => 1) (gone ++ l1 ++ [x]) <= size p - leaf p -> look (gone ++ l1 ++ [x]) <= found.
Proof.
  induction 1 as [|[b low] l blocks ls [B L] FB IH]; intros gone slack most F I; cbv zeta; cbn [scan_blocks].
  - split; [lia|]. intros l1 x s l2 E. destruct l1; discriminate.
  - simpl in B, L. set (its := if is_low then low else less (whole b) low).
    assert (ITS : its = sums_of (kept l)).
    { subst its low. rewrite (its_sums _ _ _ _ B), less_spec. unfold kept. destruct is_low; reflexivity. }
    rewrite ITS. cbn [sums_of gained reached counted]. cbn [concat] in *.
    assert (KA : kept (l ++ concat ls) = kept l ++ kept (concat ls)) by apply part_app.
    rewrite KA in F |- *. rewrite app_assoc in F. assert (FK := F). apply fit_app in FK. destruct FK as [FK _].
    assert (FG := FK). apply fit_app in FG. destruct FG as [FG SK].
    assert (TP : total packed gone + total packed (kept l) = total packed (gone ++ kept l)) by (rewrite total_app; lia).
    assert (TO : total (fun _ => 1) gone + total (fun _ => 1) (kept l) = total (fun _ => 1) (gone ++ kept l))
      by (rewrite total_app; lia).
    rewrite TP, TO. assert (ST := look_steps gone (kept l) SK).
    assert (H : forall most' slack', most <= most' -> look (gone ++ kept l) + slack' <= most' ->
      (forall l1 x s l2, kept l = l1 ++ x :: s :: l2 -> key c x <> key c s ->
        leaf p <= total (fun _ => 1) (gone ++ l1 ++ [x]) <= size p - leaf p -> look (gone ++ l1 ++ [x]) <= most') ->
      (leaf p <= total (fun _ => 1) (gone ++ kept l) <= size p - leaf p -> look (gone ++ kept l) <= most') ->
      let found := scan_blocks p edge is_low blocks (total packed (gone ++ kept l))
        (total (fun _ => 1) (gone ++ kept l)) slack' most' in
      most <= found /\ forall l1 x s l2, kept l ++ kept (concat ls) = l1 ++ x :: s :: l2 -> key c x <> key c s ->
        leaf p <= total (fun _ => 1) (gone ++ l1 ++ [x]) <= size p - leaf p -> look (gone ++ l1 ++ [x]) <= found).
    { intros most' slack' M I' IN AT. cbv zeta.
      destruct (IH (gone ++ kept l) slack' most' F I') as [M' H']. split; [lia|].
      intros l1 x s l2 E K W. destruct (neighbours _ _ _ _ _ _ E) as [(l2' & E')|[[E' _]|(l1' & -> & E')]].
      - apply Z.le_trans with most'; [apply (IN l1 x s l2'); assumption|exact M'].
      - rewrite <- E' in *. apply Z.le_trans with most'; [apply AT, W|exact M'].
      - replace (gone ++ (kept l ++ l1') ++ [x]) with ((gone ++ kept l) ++ l1' ++ [x]) in *
          by (rewrite <- !app_assoc; reflexivity).
        apply (H' l1' x s l2); assumption. }
    assert (UP : forall l1 x s l2, kept l = l1 ++ x :: s :: l2 ->
      look (gone ++ l1 ++ [x]) <= look gone + total reach (kept l) /\
      2 * look (gone ++ l1 ++ [x]) <= look gone + look (gone ++ kept l) + total reach (kept l)).
    { intros l1 x s l2 E. assert (E' : kept l = (l1 ++ [x]) ++ s :: l2) by (rewrite E, <- app_assoc; reflexivity).
      rewrite E' in SK. apply Forall_app in SK. destruct SK as [S1 S2].
      assert (A := look_steps gone (l1 ++ [x]) S1). assert (A' := look_steps (gone ++ l1 ++ [x]) (s :: l2) S2).
      rewrite <- app_assoc, <- E' in A'. rewrite E' at 1 3. rewrite total_app.
      assert (P := reach_nonneg n _ S2). lia. }
    destruct (Z.leb_spec 0 (slack - total reach (kept l))) as [SL|SL].
    + apply H; try lia. intros l1 x s l2 E _ _. specialize (UP l1 x s l2 E). lia.
    + rewrite saved_by_look by exact FK. set (within := if _ <=? _ then most else _).
      assert (W : most <= within /\ forall l1 x s l2, kept l = l1 ++ x :: s :: l2 -> key c x <> key c s ->
        leaf p <= total (fun _ => 1) (gone ++ l1 ++ [x]) <= size p - leaf p -> look (gone ++ l1 ++ [x]) <= within).
      { unfold within. destruct (Z.leb_spec (look (gone ++ kept l) + total reach (kept l)) (most + slack)) as [Q|Q].
        - split; [lia|]. intros l1 x s l2 E _ _. specialize (UP l1 x s l2 E). lia.
        - rewrite (its_run _ _ _ _ B). apply scan_held_spec; assumption. }
      destruct W as [WM WI]. set (most' := if is_wide p _ then _ else _).
      assert (M : within <= most') by (unfold most'; destruct (is_wide _ _); lia).
      apply H; [lia|lia| |].
      * intros l1 x s l2 E K W. apply Z.le_trans with within; [apply (WI l1 x s l2); assumption|exact M].
      * intros W. unfold most', is_wide.
        assert (A : (leaf p <=? total (fun _ => 1) (gone ++ kept l)) = true) by (apply Z.leb_le; lia).
        assert (A' : (total (fun _ => 1) (gone ++ kept l) <=? size p - leaf p) = true) by (apply Z.leb_le; lia).
        rewrite A, A'. simpl. lia.
Qed.

(** What is found in a column caps its cuts. *)
Theorem scan_start l blocks ls most : concat ls = l -> Forall2 is_parted blocks ls -> fit (kept l) ->
  let found := scan_blocks p edge is_low blocks 0 0 (most - saved_by p 0) most in
  most <= found /\ is_cap (joined gains samples []) (size p) (leaf p) c (kept l) found.
Proof.
  intros <- FB F. assert (E := saved_by_look [] (conj (Forall_nil _) (Z.pow_pos_nonneg 2 w eq_refl w_nonneg))).
  simpl in E. rewrite E.
  apply (scan_blocks_spec blocks ls FB [] (most - look []) most); [exact F|lia].
Qed.

End Walk.
