(** Trees over the columns of samples, what they cost, and what a bound is. *)

From Coq Require Import ZArith List Bool Arith.
Import ListNotations.
From octmip Require Import Samples.
Open Scope Z_scope.

Inductive tree :=
| Leaf (label : nat)
| Split (column : nat) (threshold : Z) (left right : tree).

Definition is_below (column : nat) (threshold : Z) (s : sample) : bool := key column s <=? threshold.
Definition lower column threshold (samples : list sample) := filter (is_below column threshold) samples.
Definition upper column threshold (samples : list sample) :=
  filter (fun s => negb (is_below column threshold s)) samples.

Fixpoint answer (t : tree) (s : sample) : nat :=
  match t with
  | Leaf label => label
  | Split column threshold l r => if is_below column threshold s then answer l s else answer r s
  end.

Fixpoint levels (t : tree) : nat :=
  match t with Leaf _ => 0 | Split _ _ l r => S (Nat.max (levels l) (levels r)) end.
Fixpoint n_splits (t : tree) : Z :=
  match t with Leaf _ => 0 | Split _ _ l r => 1 + n_splits l + n_splits r end.
Fixpoint columns (t : tree) : list nat :=
  match t with Leaf _ => [] | Split column _ l r => column :: columns l ++ columns r end.
Fixpoint labels (t : tree) : list nat :=
  match t with Leaf label => [label] | Split _ _ l r => labels l ++ labels r end.

(** Every leaf holds at least so many of the samples. *)
Fixpoint leaves_hold (least : nat) (t : tree) (samples : list sample) : Prop :=
  match t with
  | Leaf _ => (least <= length samples)%nat
  | Split column threshold l r =>
      leaves_hold least l (lower column threshold samples) /\ leaves_hold least r (upper column threshold samples)
  end.
(** A tree without a split is always allowed. *)
Definition fits (least : nat) (t : tree) (samples : list sample) : Prop :=
  (exists label, t = Leaf label) \/ leaves_hold least t samples.

Definition paid (t : tree) (samples : list sample) : Z := total (fun s => price (answer t s) s) samples.
Definition cost (penalty : Z) (t : tree) (samples : list sample) : Z := penalty * n_splits t + paid t samples.

(** Columns that may be read, labels that there are. *)
Definition is_legal (n_labels : nat) (may_read : nat -> bool) (t : tree) : Prop :=
  Forall (fun column => may_read column = true) (columns t) /\ Forall (fun label => (label < n_labels)%nat) (labels t).

(** Rules of the trees that are wanted, and whether sets of labels are gone through for their bounds. *)
Record rules := Rules { n_labels : nat; leaf_size : nat; penalty : Z; may_read : nat -> bool; with_sets : bool }.

(** No tree of [depth] levels at most costs less than [bound]. *)
Definition bounds (r : rules) (depth : nat) (samples : list sample) (bound : Z) : Prop :=
  forall t, is_legal (n_labels r) (may_read r) t -> (levels t <= depth)%nat -> fits (leaf_size r) t samples ->
  bound <= cost (penalty r) t samples.
