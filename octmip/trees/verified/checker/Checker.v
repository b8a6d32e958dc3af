(** The checker of proof logs: a function of the samples and of a log. *)

From Coq Require Import ZArith List Bool Orders Mergesort.
Import ListNotations.
From octmip Require Import Samples Trees Stumps Sides.
Open Scope Z_scope.

(** A log, as it is read: a line that cannot be read stands where it was met. Each record bears its line. *)
Inductive node :=
| Unreadable (line : Z)
| Node (line depth leaf bound : Z) (of_all : option node) (records : list record) (fault : option Z)
with record := Record (line : Z) (column : nat) (steps : list step)
with step := Step (distance : Z) (sides : list (bool * node)).

Inductive cases :=
| Case (proof : node)
| Decide (line sensor : Z) (unread read : cases)
| NoCase (line : Z).

(** Why a line is refused. *)
Inductive reason :=
| CannotBeRead
| OtherShape (depth : Z)
| CheaperTree (cost bound : Z)
| CheaperCut (place : Z) (column : nat) (cost bound : Z)
| NoSuchCut (column : nat) (place : Z)
| ProvesLess (bound claim : Z)
| NoSuchSensor (sensor : Z)
| AboveTheTrueCost (sample label : nat)
| PenaltyAbove
| WrongLengths.

Inductive checked (A : Type) := Ok (value : A) | Refused (line : Z) (why : reason).
Arguments Ok {A}.
Arguments Refused {A}.
Definition ensure {A} (holds : bool) (line : Z) (why : reason) (then_ : checked A) : checked A :=
  if holds then then_ else Refused line why.

(** A column of the samples of a node: the samples in its order, and the bounds of the two sides of its cuts after 1, 2,
    ... samples, 0 where none is known. *)
Record column := Column { index : nat; order : list sample; solved : list (Z * Z) }.

Definition unsolved (index : nat) (order : list sample) : column :=
  Column index order (match order with [] => [] | _ :: rest => map (fun _ => (0, 0)) rest end).

Fixpoint column_of (index_ : nat) (all : list column) : option column :=
  match all with
  | [] => None
  | c :: rest => if Nat.eqb (index c) index_ then Some c else column_of index_ rest
  end.

(** The cut after [distance] more samples: the number of samples to its left, the key of the last of them, and the
    samples to its right, of which there are some, all of other keys. *)
Fixpoint walk (column_ : nat) (rest : list sample) (last : option Z) (distance : Z) : option (Z * list sample) :=
  if distance =? 0 then
    match last, rest with
    | Some k, s :: _ => if k =? key column_ s then None else Some (k, rest)
    | _, _ => None
    end
  else match rest with [] => None | s :: rest' => walk column_ rest' (Some (key column_ s)) (distance - 1) end.

(** Put a value at a place, from 1. *)
Fixpoint put (place : Z) (value : Z * Z) (entries : list (Z * Z)) : list (Z * Z) :=
  match entries with
  | [] => []
  | e :: rest => if place =? 1 then value :: rest else e :: put (place - 1) value rest
  end.
Definition solve_cut (c : column) (place : Z) (sides : Z * Z) : column :=
  Column (index c) (order c) (put place sides (solved c)).
Fixpoint replace (new : column) (all : list column) : list column :=
  match all with
  | [] => []
  | c :: rest => if Nat.eqb (index c) (index new) then new :: rest else c :: replace new rest
  end.

Section Nodes.
Variable r : rules.
Let leaf_z := Z.of_nat (leaf_size r).

(** The cost of the cheapest leaf. *)
Fixpoint gains_of (samples : list sample) (gained : list Z) : list Z :=
  match samples with [] => gained | s :: rest => gains_of rest (add gained (gains s)) end.
Definition one_leaf (samples : list sample) : Z := total worst samples - top (gains_of samples []).

(** The columns, those of the records first, in their order: the sooner much is found to be saved, the less has to be
    looked at. *)
Definition is_named (records : list record) (c : column) : bool :=
  existsb (fun own => match own with Record _ column_ _ => Nat.eqb (index c) column_ end) records.
Fixpoint named (records : list record) (all : list column) : list column :=
  match records with
  | [] => []
  | Record _ column_ _ :: rest =>
      match column_of column_ all with Some c => c :: named rest all | None => named rest all end
  end.
Definition by_records (records : list record) (all : list column) : list column :=
  let first := firstn (length all) records in
  named first all ++ filter (fun c => negb (is_named first c)) all.

(** The samples in the order of each column, with their keys. *)
Definition with_keys (all : list column) : list (list (Z * sample)) :=
  map (fun c => map (fun s => (key (index c) s, s)) (order c)) all.

Definition stumps_of (place : sample -> Z) (samples : list sample) (orders : list (list (Z * sample)))
    (edges : list Z) : list (Z * Z) :=
  stumps (penalty r) leaf_z (n_labels r) place edges samples orders.

(** The cuts of a record: of each the number of samples to its left, and the key of the last of them. *)
Fixpoint read_cuts (line : Z) (column_ : nat) (steps : list step) (place : Z) (last : option Z) (rest : list sample)
    (read : list (Z * Z)) : checked (list (Z * Z)) :=
  match steps with
  | [] => Ok (rev' read)
  | Step distance _ :: steps' =>
      match walk column_ rest last distance with
      | None => Refused line (NoSuchCut column_ (place + distance))
      | Some (edge, rest') =>
          let place' := place + distance in
          read_cuts line column_ steps' place' (Some edge) rest' ((place', edge) :: read)
      end
  end.

Fixpoint solve_all (c : column) (cuts : list (Z * Z)) (sides : list (Z * Z)) : column :=
  match cuts, sides with
  | (place, _) :: cuts', both :: sides' => solve_all (solve_cut c place both) cuts' sides'
  | _, _ => c
  end.

(** Count both sides of the cuts of a column. *)
Definition count_cuts (samples : list sample) (orders : list (list (Z * sample))) (c : column) (cuts : list (Z * Z))
    : column :=
  solve_all c cuts (stumps_of (key (index c)) samples orders (map snd cuts)).

(** The columns of the samples on one side of a cut. *)
Definition columns_of (column_ : nat) (edge : Z) (is_left : bool) (all : list column) : list column :=
  map (fun c => unsolved (index c) (part_of (key column_) edge is_left (order c))) all.

(** The first and the last check of a column: no cut costs less than the bound. [left] are the bounds of the samples to
    the left of the cut at hand and of those after it, [right] those to the right. *)
Fixpoint check_cuts (line : Z) (column_ : nat) (bound n place : Z) (last : option Z)
    (rest : list sample) (left right : list Z) : checked Z :=
  match rest, left, right with
  | s :: rest', l :: left', r_ :: right' =>
      let is_cut := (leaf_z <=? place) && (place <=? n - leaf_z)
                    && match last with Some k => negb (k =? key column_ s) | None => false end in
      let cost := l + r_ + penalty r in
      if is_cut && (cost <? bound) then Refused line (CheaperCut place column_ cost bound)
      else check_cuts line column_ bound n (place + 1) (Some (key column_ s)) rest' left' right'
  | _, _, _ => Ok bound
  end.

Definition check_column (line : Z) (depth : nat) (bound bound_of_all : Z) (c : column) : checked Z :=
  let count := label_count (n_labels r) (pred depth) in
  let sets := label_sets (with_sets r) (n_labels r) (pred depth) in
  let may_grow := Nat.eqb (leaf_size r) 1 in
  let left := side count sets may_grow (order c) (map fst (solved c)) bound_of_all in
  let right := side count sets may_grow (rev' (order c)) (rev' (map snd (solved c))) bound_of_all in
  check_cuts line (index c) bound (total (fun _ => 1) (order c)) 0 None (order c) left (rev' right).

Fixpoint check_columns (line : Z) (depth : nat) (bound bound_of_all : Z) (all : list column) : checked Z :=
  match all with
  | [] => Ok bound
  | c :: rest =>
      match check_column line depth bound bound_of_all c with
      | Ok _ => check_columns line depth bound bound_of_all rest
      | Refused line why => Refused line why
      end
  end.

(** Read the records of a node whose sides are counted. *)
Fixpoint count_records (samples : list sample) (orders : list (list (Z * sample))) (all : list column)
    (records : list record) : checked (list column) :=
  match records with
  | [] => Ok all
  | Record line column_ steps :: records' =>
      match column_of column_ all with
      | None =>
          match steps with
          | [] => count_records samples orders all records'
          | Step distance _ :: _ => Refused line (NoSuchCut column_ distance)
          end
      | Some c =>
          match read_cuts line column_ steps 0 None (order c) [] with
          | Refused line why => Refused line why
          | Ok cuts =>
              let counted := count_cuts samples orders c cuts in
              count_records samples orders (replace counted all) records'
          end
      end
  end.

(** What one level less needs: the check of a node on some samples. *)
Variable check_below : list sample -> list column -> node -> checked Z.

(** The bounds of the sides of one cut, each the best of its proofs. *)
Fixpoint solve_sides (column_ : nat) (edge : Z) (samples : list sample) (all : list column)
    (sides : list (bool * node)) (left right : Z) : checked (Z * Z) :=
  match sides with
  | [] => Ok (left, right)
  | (is_left, proof) :: rest =>
      match check_below (part_of (key column_) edge is_left samples) (columns_of column_ edge is_left all) proof with
      | Refused line why => Refused line why
      | Ok bound =>
          if is_left then solve_sides column_ edge samples all rest (Z.max left bound) right
          else solve_sides column_ edge samples all rest left (Z.max right bound)
      end
  end.

Fixpoint solve_cuts (line : Z) (samples : list sample) (all : list column) (c : column)
    (steps : list step) (place : Z) (last : option Z) (rest : list sample) : checked column :=
  match steps with
  | [] => Ok c
  | Step distance sides :: steps' =>
      match walk (index c) rest last distance with
      | None => Refused line (NoSuchCut (index c) (place + distance))
      | Some (edge, rest') =>
          match solve_sides (index c) edge samples all sides 0 0 with
          | Refused line why => Refused line why
          | Ok solved_ =>
              solve_cuts line samples all (solve_cut c (place + distance) solved_)
                steps' (place + distance) (Some edge) rest'
          end
      end
  end.

Fixpoint solve_records (samples : list sample) (all : list column) (records : list record) : checked (list column) :=
  match records with
  | [] => Ok all
  | Record line column_ steps :: records' =>
      match column_of column_ all with
      | None =>
          match steps with
          | [] => solve_records samples all records'
          | Step distance _ :: _ => Refused line (NoSuchCut column_ distance)
          end
      | Some c =>
          match solve_cuts line samples all c steps 0 None (order c) with
          | Refused line why => Refused line why
          | Ok c' => solve_records samples (replace c' all) records'
          end
      end
  end.

(** What a node needs besides its cuts: the bound of one level less on all the samples, the columns with their cuts. *)
Definition solve_below (samples : list sample) (all : list column) (of_all : option node) (records : list record)
    : checked (Z * list column) :=
  let bound_of_all := match of_all with None => Ok 0 | Some proof => check_below samples all proof end in
  match bound_of_all with
  | Refused line why => Refused line why
  | Ok bound =>
      match solve_records samples all records with
      | Refused line why => Refused line why
      | Ok all' => Ok (bound, all')
      end
  end.

Definition count_below (samples : list sample) (all : list column) (records : list record)
    : checked (Z * list column) :=
  let orders := with_keys (by_records records all) in
  match count_records samples orders all records with
  | Refused line why => Refused line why
  | Ok all' => Ok (fst (hd (0, 0) (stumps_of (fun _ => 0) samples orders [0])), all')
  end.

End Nodes.

(** Check a node: every tree of [depth] levels at most on these samples costs the bound that it names. *)
Fixpoint check_node (r : rules) (depth : nat) (samples : list sample) (all : list column) (proof : node) : checked Z :=
  match depth, proof with
  | S depth', Node line levels leaf bound of_all records fault =>
      ensure ((levels =? Z.of_nat depth) && (leaf =? Z.of_nat (leaf_size r))) line (OtherShape (Z.of_nat depth))
      (match (if Nat.leb depth 2 then count_below r samples all records
              else solve_below (check_node r depth') samples all of_all records) with
      | Refused line why => Refused line why
      | Ok (bound_of_all, all') =>
          match fault with
          | Some line => Refused line CannotBeRead
          | None =>
              let best := if Nat.eqb depth 1 then bound_of_all else one_leaf samples in
              ensure (bound <=? best) line (CheaperTree best bound)
              (if Nat.eqb depth 1 then Ok bound else check_columns r line depth bound bound_of_all all')
          end
      end)
  | _, Unreadable line => Refused line CannotBeRead
  | O, Node line _ _ _ _ _ _ => Refused line (OtherShape (Z.of_nat depth))
  end.
