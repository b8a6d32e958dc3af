(** The cheapest tree of one split at most, counted exactly on parts of the samples that shrink from one to the next. *)

From Coq Require Import ZArith List Bool.
Import ListNotations.
From octmip Require Import Samples.
Open Scope Z_scope.

(** Samples in the order of a column: the place of each in the column that parts the samples, its gains and its reach,
    and its key. *)
Inductive run :=
| Done
| Next (place : Z) (its_gains : list Z) (its_reach : Z) (its_key : Z) (rest : run).

Fixpoint run_of (place : sample -> Z) (column : nat) (order : list sample) : run :=
  match order with
  | [] => Done
  | s :: rest => Next (place s) (gains s) (reach s) (key column s) (run_of place column rest)
  end.

(** A part of the samples: those whose place is at most [edge], or ([is_lower] false) those whose place is above. *)
Definition is_in (edge : Z) (is_lower : bool) (place : Z) : bool := Bool.eqb (place <=? edge) is_lower.

Fixpoint keep (edge : Z) (is_lower : bool) (r : run) : run :=
  match r with
  | Done => Done
  | Next place g i k rest =>
      if is_in edge is_lower place then Next place g i k (keep edge is_lower rest) else keep edge is_lower rest
  end.

Definition differs (its_key : Z) (rest : run) : bool :=
  match rest with Done => false | Next _ _ _ other _ => negb (its_key =? other) end.

(** What does not change along a run: gains, reach and number of its samples, and the fewest in a leaf. *)
Record part := Part { all_gains : list Z; all_reach : Z; size : Z; leaf : Z }.

(** The most that a cut of the run saves, or [most] if that is more.

    [gone] are the gains of the samples so far, [count] their number. At every place the best cut there saves at most
    [most - slack]: a sample that goes over to the left adds its reach at most. So nothing is looked at until the slack
    is used up; where the samples that are [left] reach no further, nothing is looked at any more. *)
Fixpoint scan (p : part) (r : run) (gone : list Z) (count slack left most : Z) : Z :=
  match r with
  | Done => most
  | Next _ its_gains its_reach its_key rest =>
      let gone' := add gone its_gains in
      let count' := count + 1 in
      let slack' := slack - its_reach in
      let left' := left - its_reach in
      if (slack' <? 0) && differs its_key rest then
        let saved := top gone' + top_gap (all_gains p) gone' in
        let is_wide := (leaf p <=? count') && (count' <=? size p - leaf p) in
        let most' := if is_wide then Z.max most saved else most in
        scan p rest gone' count' (most' - saved) left' most'
      else if left' <=? slack' then most
      else scan p rest gone' count' slack' left' most
  end.

(** The sums over samples: gains, cost under the most expensive labels, number. *)
Fixpoint sums (samples : list sample) (gained : list Z) (most count : Z) : list Z * Z * Z :=
  match samples with
  | [] => (gained, most, count)
  | s :: rest => sums rest (add gained (gains s)) (most + worst s) (count + 1)
  end.

Definition part_of (place : sample -> Z) (edge : Z) (is_lower : bool) (samples : list sample) : list sample :=
  filter (fun s => is_in edge is_lower (place s)) samples.

(** A part that is counted: where it ends, its sums, what its samples cost at most, and the most that is found to be
    saved of that. *)
Record counted := Counted { its_edge : Z; its_part : part; its_worst : Z; found : Z }.

(** The parts that end at these edges, each within the one before. A leaf is a split that saves what it pays. *)
Fixpoint parts_of (penalty leaf : Z) (place : sample -> Z) (is_lower : bool) (edges : list Z) (samples : list sample)
    : list counted :=
  match edges with
  | [] => []
  | edge :: edges' =>
      let kept := part_of place edge is_lower samples in
      let '(gained, most, count) := sums kept [] 0 0 in
      Counted edge (Part gained (total reach kept) count leaf) most (top gained + penalty)
        :: parts_of penalty leaf place is_lower edges' kept
  end.

(** Count a column of all parts. *)
Fixpoint scan_parts (is_lower : bool) (parts : list counted) (r : run) : list counted :=
  match parts with
  | [] => []
  | c :: parts' =>
      let kept := keep (its_edge c) is_lower r in
      let p := its_part c in
      let most := scan p kept [] 0 (found c - top (all_gains p)) (all_reach p) (found c) in
      Counted (its_edge c) p (its_worst c) most :: scan_parts is_lower parts' kept
  end.

Fixpoint are_nested (is_lower : bool) (edges : list Z) : bool :=
  match edges with
  | [] => true
  | edge :: rest =>
      match rest with [] => true | next :: _ => if is_lower then next <=? edge else edge <=? next end
      && are_nested is_lower rest
  end.

(** What the cheapest tree of one split at most costs on each of the parts, of a split whose leaves are large enough.
    Nothing is said of parts that do not lie in one another. One column after the other, since its run is short. *)
Definition stumps (penalty leaf : Z) (place : sample -> Z) (is_lower : bool) (edges : list Z)
    (samples : list sample) (runs : list run) : list Z :=
  if are_nested is_lower edges then
    let parts := fold_left (scan_parts is_lower) runs (parts_of penalty leaf place is_lower edges samples) in
    map (fun c => its_worst c + penalty - found c) parts
  else map (fun _ => 0) edges.
