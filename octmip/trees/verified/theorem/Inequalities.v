(** The inequalities that carry a proof: growing, shrinking, a node. *)

From Coq Require Import ZArith List Bool Permutation Lia Arith.
Import ListNotations.
From octmip Require Import Samples Sums Trees.
Open Scope Z_scope.
Local Arguments Z.add : simpl never.
Local Arguments Z.sub : simpl never.
Local Arguments Z.mul : simpl never.

(** * Trees on parts of the samples *)

Lemma filter_perm keep (l l' : list sample) : Permutation l l' -> Permutation (filter keep l) (filter keep l').
Proof.
  induction 1; simpl; auto.
  - destruct (keep x); auto.
  - destruct (keep x), (keep y); auto. apply perm_swap.
  - eapply Permutation_trans; eauto.
Qed.

Lemma filter_shorter keep (l : list sample) : (length (filter keep l) <= length l)%nat.
Proof. induction l as [|s l IH]; simpl; [lia|]. destruct (keep s); simpl; lia. Qed.

Lemma lower_app c t l l' : lower c t (l ++ l') = lower c t l ++ lower c t l'.
Proof. apply filter_app. Qed.
Lemma upper_app c t l l' : upper c t (l ++ l') = upper c t l ++ upper c t l'.
Proof. apply filter_app. Qed.

Lemma paid_app t l l' : paid t (l ++ l') = paid t l + paid t l'.
Proof. apply total_app. Qed.

Lemma n_splits_nonneg t : 0 <= n_splits t.
Proof. induction t; simpl; lia. Qed.

Lemma paid_split c t l r samples :
  paid (Split c t l r) samples = paid l (lower c t samples) + paid r (upper c t samples).
Proof.
  unfold paid. rewrite (total_filter _ (is_below c t)). f_equal; apply total_ext; intros s I;
    apply filter_In in I; destruct I as [_ B]; simpl; destruct (is_below c t s); simpl in B; congruence.
Qed.

Lemma cost_split p c t l r samples :
  cost p (Split c t l r) samples = p + cost p l (lower c t samples) + cost p r (upper c t samples).
Proof. unfold cost. rewrite paid_split. simpl n_splits. lia. Qed.

Lemma leaves_hold_perm least t : forall l l', Permutation l l' -> leaves_hold least t l -> leaves_hold least t l'.
Proof.
  induction t; simpl; intros l l' P H.
  - rewrite <- (Permutation_length P). exact H.
  - destruct H. split;
      [apply IHt1 with (l := lower column threshold l)|apply IHt2 with (l := upper column threshold l)];
      auto; apply filter_perm; auto.
Qed.

Lemma leaves_hold_app least t : forall l l', leaves_hold least t l -> leaves_hold least t (l ++ l').
Proof.
  induction t; simpl; intros l l' H.
  - rewrite app_length. lia.
  - rewrite lower_app, upper_app. destruct H. split; auto.
Qed.

Lemma leaves_hold_length least t : forall l, leaves_hold least t l -> (least <= length l)%nat.
Proof.
  induction t; simpl; intros l H; [exact H|]. destruct H as [H _]. apply IHt1 in H.
  unfold lower in H. assert (F := filter_shorter (is_below column threshold) l). lia.
Qed.

Lemma answer_in t s : In (answer t s) (labels t).
Proof.
  induction t; simpl; [auto|]. apply in_or_app. destruct (is_below column threshold s); auto.
Qed.

Lemma answer_legal n may t s : is_legal n may t -> (answer t s < n)%nat.
Proof. intros [_ L]. rewrite Forall_forall in L. apply L, answer_in. Qed.

Lemma legal_split n may c t l r : is_legal n may (Split c t l r) -> may c = true /\ is_legal n may l /\ is_legal n may
  r.
Proof.
  intros [C L]. simpl in C, L. inversion C as [|? ? C0 C1]; subst. apply Forall_app in C1. apply Forall_app in L.
  unfold is_legal. tauto.
Qed.

Lemma labels_length t : (length (labels t) <= 2 ^ levels t)%nat.
Proof.
  induction t; simpl; [lia|]. rewrite app_length.
  assert (2 ^ levels t1 <= 2 ^ Nat.max (levels t1) (levels t2))%nat by (apply Nat.pow_le_mono_r; lia).
  assert (2 ^ levels t2 <= 2 ^ Nat.max (levels t1) (levels t2))%nat by (apply Nat.pow_le_mono_r; lia). lia.
Qed.

(** * Bounds *)

Section Rules.
Variable r : rules.
Hypothesis penalty_nonneg : 0 <= penalty r.

Definition all_sound (samples : list sample) : Prop := Forall (sound (n_labels r)) samples.

Lemma bounds_perm d l l' b : Permutation l l' -> bounds r d l b -> bounds r d l' b.
Proof.
  intros P H t T D F. unfold cost, paid. rewrite <- (total_perm _ _ _ P). apply H; auto.
  destruct F as [F|F]; [left; exact F|right]. eapply leaves_hold_perm; [|exact F]. apply Permutation_sym, P.
Qed.

Lemma bounds_le d l b b' : bounds r d l b -> b' <= b -> bounds r d l b'.
Proof. intros H L t T D F. specialize (H t T D F). lia. Qed.

Lemma bounds_max d l b b' : bounds r d l b -> bounds r d l b' -> bounds r d l (Z.max b b').
Proof. intros H H' t T D F. specialize (H t T D F). specialize (H' t T D F). lia. Qed.

Lemma cost_nonneg t l : all_sound l -> is_legal (n_labels r) (may_read r) t -> 0 <= cost (penalty r) t l.
Proof.
  intros S T. unfold cost. assert (N := n_splits_nonneg t).
  assert (0 <= paid t l).
  { apply total_nonneg. intros s I. unfold all_sound in S. rewrite Forall_forall in S.
    apply (price_nonneg _ _ (S s I)). eapply answer_legal, T. }
  nia.
Qed.

Lemma bounds_zero d l : all_sound l -> bounds r d l 0.
Proof. intros S t T _ _. apply cost_nonneg; auto. Qed.

(** ** Shrinking *)

Theorem shrinking d l m b :
  all_sound m -> bounds r d (l ++ m) b -> bounds r d l (b - total worst m).
Proof.
  intros S H t T D F.
  assert (G : b <= cost (penalty r) t (l ++ m)).
  { apply H; auto. destruct F as [F|F]; [left; exact F|right]. apply leaves_hold_app, F. }
  assert (W : paid t m <= total worst m).
  { apply total_le. intros s I. unfold all_sound in S. rewrite Forall_forall in S.
    apply price_le_worst with (n := n_labels r); [auto|]. eapply answer_legal, T. }
  unfold cost in *. rewrite paid_app in G. lia.
Qed.

(** ** Growing *)

(** The tree without the splits that send all samples to one side. *)
Fixpoint pruned (t : tree) (samples : list sample) : tree :=
  match t with
  | Leaf _ => t
  | Split c threshold l r =>
      match lower c threshold samples, upper c threshold samples with
      | [], _ => pruned r samples
      | _, [] => pruned l samples
      | low, up => Split c threshold (pruned l low) (pruned r up)
      end
  end.

Lemma all_lower c t l : upper c t l = [] -> lower c t l = l.
Proof.
  induction l as [|s l IH]; simpl; auto. destruct (is_below c t s); simpl; intros H; [|discriminate].
  f_equal. auto.
Qed.
Lemma all_upper c t l : lower c t l = [] -> upper c t l = l.
Proof.
  induction l as [|s l IH]; simpl; auto. destruct (is_below c t s); simpl; intros H; [discriminate|].
  f_equal. auto.
Qed.

Lemma pruned_spec t : forall l, l <> [] -> is_legal (n_labels r) (may_read r) t ->
  is_legal (n_labels r) (may_read r) (pruned t l) /\ (levels (pruned t l) <= levels t)%nat /\
  leaves_hold 1 (pruned t l) l /\ n_splits (pruned t l) <= n_splits t /\ paid (pruned t l) l = paid t l.
Proof.
  induction t as [a|c th t1 IH1 t2 IH2]; intros l N T.
  - simpl. split; [exact T|]. split; [lia|]. split; [destruct l; simpl; [congruence|lia]|]. split; [lia|reflexivity].
  - destruct (legal_split _ _ _ _ _ _ T) as (C & T1 & T2).
    assert (N1 := n_splits_nonneg t1). assert (N2 := n_splits_nonneg t2).
    simpl pruned. destruct (lower c th l) as [|s low] eqn:L.
    + destruct (IH2 l N T2) as (A & B & D & E & F). split; [exact A|]. split; [simpl; lia|]. split; [exact D|].
      split; [simpl; lia|]. rewrite paid_split, L, (all_upper _ _ _ L). unfold paid at 2. simpl. lia.
    + destruct (upper c th l) as [|u up] eqn:U.
      * destruct (IH1 l N T1) as (A & B & D & E & F). split; [exact A|]. split; [simpl; lia|]. split; [exact D|].
        split; [simpl; lia|]. rewrite paid_split, U, (all_lower _ _ _ U). unfold paid at 3. simpl. lia.
      * destruct (IH1 (s :: low)) as (A & B & D & E & F); [discriminate|auto|].
        destruct (IH2 (u :: up)) as (A' & B' & D' & E' & F'); [discriminate|auto|].
        split; [destruct A as [A0 A1], A' as [A0' A1']; split; simpl; [constructor; [exact C|]|]; apply Forall_app;
          auto|].
        split; [simpl; lia|].
        split; [simpl leaves_hold; rewrite L, U; auto|].
        split; [simpl; lia|]. rewrite !paid_split, L, U. lia.
Qed.

(** What samples cost at least in a tree of so many levels, by labels alone. *)
Definition spreads (d : nat) (m : list sample) (g : Z) : Prop :=
  forall t, is_legal (n_labels r) (may_read r) t -> (levels t <= d)%nat -> g <= paid t m.

Theorem growing d l m b g :
  leaf_size r = 1%nat -> l <> [] -> spreads d m g -> bounds r d l b -> bounds r d (l ++ m) (b + g).
Proof.
  intros L1 N G H t T D _.
  destruct (pruned_spec t l N T) as (A & B & C & E & F).
  assert (b <= cost (penalty r) (pruned t l) l) by (apply H; auto; [lia|right; rewrite L1; exact C]).
  assert (g <= paid t m) by (apply G; auto).
  unfold cost in *. rewrite paid_app, F in *. nia.
Qed.

Theorem growing_from_none d m g : spreads d m g -> bounds r d m g.
Proof.
  intros G t T D _. assert (g <= paid t m) by (apply G; auto). unfold cost.
  assert (N := n_splits_nonneg t). nia.
Qed.

(** ** A node *)

Definition leaf_bounds (l : list sample) (b : Z) : Prop :=
  forall label, (label < n_labels r)%nat -> b <= paid (Leaf label) l.

(** Every cut that leaves enough samples on both sides costs the bound. *)
Definition cuts_bound (d : nat) (l : list sample) (b : Z) : Prop :=
  forall c th, may_read r c = true ->
  (leaf_size r <= length (lower c th l))%nat -> (leaf_size r <= length (upper c th l))%nat ->
  exists b1 b2, bounds r d (lower c th l) b1 /\ bounds r d (upper c th l) b2 /\ b <= penalty r + b1 + b2.

Theorem node d l b : leaf_bounds l b -> cuts_bound d l b -> bounds r (S d) l b.
Proof.
  intros LB CB t T D F. destruct t as [a|c th t1 t2].
  - unfold cost. simpl n_splits. rewrite Z.mul_0_r. apply LB. destruct T as [_ T]. inversion T; auto.
  - destruct F as [[a E]|[F1 F2]]; [discriminate|].
    destruct (legal_split _ _ _ _ _ _ T) as (C & T1 & T2).
    destruct (CB c th C) as (b1 & b2 & B1 & B2 & E); [eapply leaves_hold_length; eauto..|].
    simpl in D. rewrite cost_split.
    assert (b1 <= cost (penalty r) t1 (lower c th l)) by (apply B1; [auto|lia|right; auto]).
    assert (b2 <= cost (penalty r) t2 (upper c th l)) by (apply B2; [auto|lia|right; auto]). lia.
Qed.

End Rules.
