(** The cheapest tree of one split at most, counted exactly on the samples below and above the cuts of a column. *)

From Coq Require Import ZArith List Bool.
Import ListNotations.
From octmip Require Import Samples.
Open Scope Z_scope.

(** Samples in the order of a column: the place of each in the column that parts the samples, its gains, packed, its
    reach, and its key. *)
Inductive run :=
| Done
| Next (place its_gains its_reach its_key : Z) (rest : run).

(** Sums over some samples: packed gains, reach, number. *)
Record sums := Sums { gained : Z; reached : Z; counted : Z }.
Definition less (all some : sums) : sums :=
  Sums (gained all - gained some) (reached all - reached some) (counted all - counted some).

(** Some samples that follow each other in a column. No place is below [lowest] or above [highest]. *)
Record block := Block { held : run; whole : sums; lowest : Z; highest : Z }.

Fixpoint close (all r : run) (g i n low high : Z) : block :=
  match r with
  | Done => Block all (Sums g i n) low high
  | Next place g' i' _ rest => close all rest (g + g') (i + i') (n + 1) (Z.min low place) (Z.max high place)
  end.
Definition put_before (r : run) (blocks : list block) : list block :=
  match r with
  | Done => blocks
  | Next place g i _ rest => close r rest g i 1 place place :: blocks
  end.

Definition differs (its_key : Z) (rest : run) : bool :=
  match rest with Done => false | Next _ _ _ other _ => negb (its_key =? other) end.

(** The samples of an order, with their keys, in blocks: the first of them, of [free] samples and one more, and the
    others. Samples of one key are in one block. *)
Definition block_size : nat := 15.
Fixpoint split_order (place : sample -> Z) (free : nat) (order : list (Z * sample)) : run * list block :=
  match order with
  | [] => (Done, [])
  | (k, s) :: rest =>
      let '(r, blocks) := split_order place (match free with O => block_size | S free' => free' end) rest in
      match free with
      | O => if differs k r then (Next (place s) (packed s) (reach s) k Done, put_before r blocks)
             else (Next (place s) (packed s) (reach s) k r, blocks)
      | S _ => (Next (place s) (packed s) (reach s) k r, blocks)
      end
  end.
Definition blocks_of (place : sample -> Z) (order : list (Z * sample)) : list block :=
  let '(r, blocks) := split_order place block_size order in put_before r blocks.

(** A part of the samples: those whose place is at most [edge], or ([is_lower] false) those whose place is above. *)
Definition is_in (edge : Z) (is_lower : bool) (place : Z) : bool := Bool.eqb (place <=? edge) is_lower.

(** The sums of the samples whose place is at most [edge]. *)
Fixpoint sums_below (edge : Z) (r : run) (g i n : Z) : sums :=
  match r with
  | Done => Sums g i n
  | Next place g' i' _ rest =>
      if place <=? edge then sums_below edge rest (g + g') (i + i') (n + 1) else sums_below edge rest g i n
  end.
Definition below (edge : Z) (b : block) : sums :=
  if highest b <=? edge then whole b else if edge <? lowest b then Sums 0 0 0 else sums_below edge (held b) 0 0 0.

(** What does not change along an order: the packed gains and the number of its samples, the fewest in a leaf, and how
    gains are packed. *)
Record part := Part { all_gains : Z; size : Z; leaf : Z; n_gains : nat; its_width : Z; mask : Z }.

Definition saved_by (p : part) (gone : Z) : Z := saved (n_gains p) (its_width p) (mask p) (all_gains p) gone 0 0.
Definition is_wide (p : part) (count : Z) : bool := (leaf p <=? count) && (count <=? size p - leaf p).

(** The most that a cut within the run saves, or [most] if that is more.

    [gone] are the gains of the samples so far, [count] their number. At every place the best cut there saves at most
    [most - slack]: a sample that goes over to the left adds its reach at most. So nothing is looked at until the slack
    is used up. *)
Fixpoint scan (p : part) (edge : Z) (is_lower : bool) (r : run) (last gone count slack most : Z) : Z :=
  match r with
  | Done => most
  | Next place g i k rest =>
      if is_in edge is_lower place then
        if (slack <? 0) && negb (last =? k) then
          let own := saved_by p gone in
          let most' := if is_wide p count then Z.max most own else most in
          scan p edge is_lower rest k (gone + g) (count + 1) (most' - own - i) most'
        else scan p edge is_lower rest k (gone + g) (count + 1) (slack - i) most
      else scan p edge is_lower rest last gone count slack most
  end.
Definition scan_held (p : part) (edge : Z) (is_lower : bool) (r : run) (gone count slack most : Z) : Z :=
  match r with Done => most | Next _ _ _ k _ => scan p edge is_lower r k gone count slack most end.

(** The same of blocks. Within a block, a cut saves at most half of its reach more than the cuts at both ends do on
    average: that is how far one can go up from both. *)
Fixpoint scan_blocks (p : part) (edge : Z) (is_lower : bool) (blocks : list (block * sums))
    (gone count slack most : Z) : Z :=
  match blocks with
  | [] => most
  | (b, lower) :: rest =>
      let its := if is_lower then lower else less (whole b) lower in
      let gone' := gone + gained its in
      let count' := count + counted its in
      let slack' := slack - reached its in
      if 0 <=? slack' then scan_blocks p edge is_lower rest gone' count' slack' most
      else
        let own := saved_by p gone' in
        let within := if own + reached its <=? most + slack then most
                      else scan_held p edge is_lower (held b) gone count slack most in
        let most' := if is_wide p count' then Z.max within own else within in
        scan_blocks p edge is_lower rest gone' count' (most' - own) most'
  end.

Definition part_of (place : sample -> Z) (edge : Z) (is_lower : bool) (samples : list sample) : list sample :=
  filter (fun s => is_in edge is_lower (place s)) samples.

(** The sums over the samples whose place is at most [edge]: packed gains, cost under the most expensive labels,
    number. *)
Fixpoint sum_below (edge : Z) (samples : list (Z * sample)) (its_gains most count : Z) : Z * Z * Z :=
  match samples with
  | [] => (its_gains, most, count)
  | (place, s) :: rest =>
      if place <=? edge then sum_below edge rest (its_gains + packed s) (most + worst s) (count + 1)
      else sum_below edge rest its_gains most count
  end.

(** What is counted of the samples on one side of an edge: what they cost at most, and the most that is found to be
    saved of that. A leaf is a split that saves what it pays. *)
Record side_sums := Side { its_part : part; its_worst : Z; found : Z }.
Definition side_of (penalty : Z) (p : part) (most : Z) : side_sums := Side p most (saved_by p 0 + penalty).

Definition scan_side (edge : Z) (is_lower : bool) (blocks : list (block * sums)) (s : side_sums) : side_sums :=
  let p := its_part s in
  Side p (its_worst s) (scan_blocks p edge is_lower blocks 0 0 (found s - saved_by p 0) (found s)).

(** Both sides of an edge. *)
Record cut_sums := Cut { its_edge : Z; low : side_sums; high : side_sums }.
Definition cut_of (penalty leaf : Z) (n : nat) (w : Z) (samples : list (Z * sample)) (its_gains most count edge : Z)
    : cut_sums :=
  let '(g, m, c) := sum_below edge samples 0 0 0 in
  let part_with := fun g' c' => Part g' c' leaf n w (2 ^ w - 1) in
  Cut edge (side_of penalty (part_with g c) m)
    (side_of penalty (part_with (its_gains - g) (count - c)) (most - m)).

(** Count a column of both sides of all edges. *)
Definition scan_cut (blocks : list block) (c : cut_sums) : cut_sums :=
  let edge := its_edge c in
  let lower := map (fun b => (b, below edge b)) blocks in
  Cut edge (scan_side edge true lower (low c)) (scan_side edge false lower (high c)).

Definition scan_order (place : sample -> Z) (cuts : list cut_sums) (order : list (Z * sample)) : list cut_sums :=
  let blocks := blocks_of place order in map (scan_cut blocks) cuts.

(** How gains are packed, if all are packed alike and their sums cannot run into one another. *)
Definition common_width (samples : list sample) : option Z :=
  match samples with
  | [] => Some 0
  | s :: _ =>
      if forallb (fun other => width other =? width s) samples && (total reach samples <? 2 ^ width s)
      then Some (width s) else None
  end.

(** What the cheapest tree of one split at most costs on each side of the edges, of a split whose leaves are large
    enough. Nothing is said where sums may run into one another. One column after the other, since what is read of one
    is short. *)
Definition stumps (penalty leaf : Z) (n : nat) (place : sample -> Z) (edges : list Z) (samples : list sample)
    (orders : list (list (Z * sample))) : list (Z * Z) :=
  match common_width samples with
  | Some w =>
      let placed := map (fun s => (place s, s)) samples in
      let first := map (cut_of penalty leaf n w placed
        (total packed samples) (total worst samples) (total (fun _ => 1) samples)) edges in
      let bound := fun s => its_worst s + penalty - found s in
      map (fun c => (bound (low c), bound (high c))) (fold_left (scan_order place) orders first)
  | None => map (fun _ => (0, 0)) edges
  end.
