(** What is asked and what is claimed, without a word of how it is checked: all that a reader of the theorem has to
    believe. *)

From Coq Require Import ZArith List.
Import ListNotations.
Open Scope Z_scope.

(** A row of the data: a reading of each feature, none where it is missing; its class and weight. Readings, weights and
    costs are whole numbers, each kind in a unit of its own. *)
Record row := Row { readings : list (option Z); class : nat; weight : Z }.

Record question := Question {
  rows : list row;
  n_classes : nat;
  costs : list (list Z);          (** by class: the cost of each label *)
  split_penalty : Z;              (** in units of weight times cost *)
  depth : nat;
  fewest : nat;                   (** samples in a leaf *)
  sensors : list nat;             (** by feature: the sensor that it is read from *)
  sensor_costs : list Z;
  budget : option Z;
  allowed : list bool             (** by feature *)
}.

(** A split sends a row left if its reading is at most the threshold; a row without the reading goes where the split
    says. *)
Inductive tree :=
| Leaf (label : nat)
| Split (feature : nat) (threshold : Z) (missing_goes_left : bool) (left right : tree).

Definition reading (feature : nat) (x : row) : option Z := nth feature (readings x) None.
Definition goes_left (feature : nat) (threshold : Z) (missing_goes_left : bool) (x : row) : bool :=
  match reading feature x with
  | Some value => value <=? threshold
  | None => missing_goes_left
  end.

Fixpoint label_of (t : tree) (x : row) : nat :=
  match t with
  | Leaf label => label
  | Split feature threshold missing l r =>
      if goes_left feature threshold missing x then label_of l x else label_of r x
  end.

Fixpoint n_levels (t : tree) : nat :=
  match t with Leaf _ => 0 | Split _ _ _ l r => S (Nat.max (n_levels l) (n_levels r)) end.
Fixpoint n_splits (t : tree) : Z :=
  match t with Leaf _ => 0 | Split _ _ _ l r => 1 + n_splits l + n_splits r end.
Fixpoint features (t : tree) : list nat :=
  match t with Leaf _ => [] | Split feature _ _ l r => feature :: features l ++ features r end.
Fixpoint labels (t : tree) : list nat :=
  match t with Leaf label => [label] | Split _ _ _ l r => labels l ++ labels r end.

(** Every leaf holds at least so many of the rows. *)
Fixpoint leaves_hold (least : nat) (t : tree) (xs : list row) : Prop :=
  match t with
  | Leaf _ => (least <= length xs)%nat
  | Split feature threshold missing l r =>
      leaves_hold least l (filter (goes_left feature threshold missing) xs) /\
      leaves_hold least r (filter (fun x => negb (goes_left feature threshold missing x)) xs)
  end.

(** The cost of a label for a row, and of a tree for all rows. *)
Definition loss (q : question) (label : nat) (x : row) : Z := weight x * nth label (nth (class x) (costs q) []) 0.
Fixpoint losses (q : question) (t : tree) (xs : list row) : Z :=
  match xs with [] => 0 | x :: rest => loss q (label_of t x) x + losses q t rest end.
Definition tree_cost (q : question) (t : tree) : Z := split_penalty q * n_splits t + losses q t (rows q).

(** The sensors that a tree reads, and what they cost together. *)
Definition sensor_of (q : question) (feature : nat) : nat := nth feature (sensors q) 0%nat.
Definition reads (q : question) (t : tree) (sensor : nat) : bool :=
  existsb (fun feature => Nat.eqb (sensor_of q feature) sensor) (features t).
Fixpoint paid_from (q : question) (t : tree) (sensor : nat) (prices : list Z) : Z :=
  match prices with
  | [] => 0
  | price :: rest => (if reads q t sensor then price else 0) + paid_from q t (S sensor) rest
  end.
Definition sensor_cost (q : question) (t : tree) : Z := paid_from q t 0 (sensor_costs q).

(** Sums of sensor costs are rounded elsewhere: whatever may be within the budget, to twelve digits, is. *)
Definition is_within (q : question) (paid : Z) : Prop :=
  match budget q with
  | None => True
  | Some most => paid * (10 ^ 12 - 1) <= most * 10 ^ 12
  end.

(** The trees that are asked for. A tree without a split is allowed whatever its leaf holds. *)
Definition is_asked_for (q : question) (t : tree) : Prop :=
  (n_levels t <= depth q)%nat /\
  Forall (fun label => (label < n_classes q)%nat) (labels t) /\
  Forall (fun feature => nth feature (allowed q) false = true) (features t) /\
  ((exists label, t = Leaf label) \/ leaves_hold (fewest q) t (rows q)) /\
  is_within q (sensor_cost q t).
