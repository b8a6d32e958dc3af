(* The body of a log, as a tree of records. Nothing here is trusted: whatever it returns, the verified checker accepts
   no false claim. *)

open Verified
module Z = Integer

(* A line that cannot be read ends the reading: the checker refuses it when it comes to it. *)
type t = {
  cursor : Lines.t;
  reasons : (int, string) Hashtbl.t; (* why a line cannot be read *)
  strangers : (int, Z.t) Hashtbl.t; (* the feature that a line names, if there is none *)
  n_features : int;
  mutable is_broken : bool;
}

let broken b line reason =
  b.is_broken <- true;
  Hashtbl.replace b.reasons line reason;
  Z.of_int line

let rec node b depth =
  match Lines.expect b.cursor "N" 3 with
  | [ levels; leaf; bound ] ->
      let line = Z.of_int b.cursor.n_read in
      let of_all = if depth > 2 && Lines.take b.cursor "B" <> None then Some (node b (depth - 1)) else None in
      let records = records b depth [] in
      let fault = if b.is_broken then None else ending b in
      Node (line, levels, leaf, bound, of_all, records, fault)
  | _ -> assert false
  | exception Lines.Refused (line, reason) -> Unreadable (broken b line reason)

and ending b =
  match Lines.expect b.cursor "E" 0 with
  | _ -> None
  | exception Lines.Refused (line, reason) -> Some (broken b line reason)

and records b depth found =
  match if b.is_broken then None else Lines.take b.cursor (if depth <= 2 then "F" else "K") with
  | None -> List.rev found
  | Some numbers ->
      let line = Z.of_int b.cursor.n_read in
      let feature, distances =
        match numbers with
        | [] -> (b.n_features, [])
        | f :: rest when Z.lt f (Z.of_int b.n_features) -> (Z.to_int f, rest)
        | f :: rest -> Hashtbl.replace b.strangers b.cursor.n_read f; (b.n_features, rest)
      in
      let step distance = Step (distance, if depth <= 2 then [] else sides b depth true []) in
      let steps = List.rev (List.fold_left (fun steps distance -> step distance :: steps) [] distances) in
      records b depth (Record (line, Question.nat feature, steps) :: found)

(* The proofs of the left sides of a cut, then those of the right. *)
and sides b depth is_left found =
  if b.is_broken then List.rev found
  else if Lines.take b.cursor (if is_left then "L" else "R") <> None then
    sides b depth is_left ((is_left, node b (depth - 1)) :: found)
  else if is_left then sides b depth false found
  else List.rev found

(* The cases of sensors. No proof has more decisions in one another than there are sensors. *)
let rec cases b depth n_open =
  let is_decision = match Lines.peek b.cursor with Some line -> Lines.starts_with "S " line | None -> false in
  if b.is_broken || n_open < 0 then NoCase Z.zero
  else if not is_decision then Case (node b depth)
  else
    match Lines.expect b.cursor "S" 1 with
    | [ sensor ] ->
        let line = Z.of_int b.cursor.n_read in
        let unread = cases b depth (n_open - 1) in
        Decide (line, sensor, unread, cases b depth (n_open - 1))
    | _ -> assert false
    | exception Lines.Refused (line, reason) -> NoCase (broken b line reason)

(* Columns: a feature with missing readings is two. *)
let n_columns (q : Problem.t) =
  let has_missing f = Array.exists (fun own -> own.(f) = None) q.readings in
  List.fold_left (fun n f -> if has_missing f then n + 2 else n + 1) 0 (List.init q.p Fun.id)

let read (q : Problem.t) cursor =
  let b =
    { cursor; reasons = Hashtbl.create 4; strangers = Hashtbl.create 4; n_features = n_columns q; is_broken = false }
  in
  (cases b q.depth (Array.length q.sensor_cost), b)
