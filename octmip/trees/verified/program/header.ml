(* The header of a log: the problem that it is of, the whole numbers that it counts in, its claim. *)

open Verified
module Z = Integer

let format = "octmip-proof 3"
let capacity = Z.shift_left Z.one 61
let most_exponent = 2200
let most_own_rows = 1024

type t = { numbers : numbers; claim : Z.t }

let signed word =
  if Lines.starts_with "-" word then Option.map Z.neg (Lines.whole_number (String.sub word 1 (String.length word - 1)))
  else Lines.whole_number word

(* The numbers of the next line, which must have this name: so many (0: one or more), all from [least] to [most]. *)
let numbers c name (least, most) count expected =
  let text = Option.value (Lines.read c) ~default:"" in
  let fits values =
    (count = 0 || List.length values = count) && List.for_all (fun v -> Z.leq least v && Z.leq v most) values
  in
  match String.split_on_char ' ' text with
  | first :: words when first = name && words <> [] -> (
      match Lines.all_numbers signed words with
      | Some values when fits values -> values
      | _ -> Lines.refuse c.n_read (Printf.sprintf "got %s, expected %S and %s" (Lines.shown text) name expected))
  | _ -> Lines.refuse c.n_read (Printf.sprintf "got %s, expected %S and %s" (Lines.shown text) name expected)

let exponents = (Z.of_int (-most_exponent), Z.of_int most_exponent)
let wholes = (Z.zero, Z.pred capacity)

let check_identity (q : Problem.t) c =
  let first = format ^ if Problem.has_missing q then " missing" else "" in
  let got = Option.value (Lines.read c) ~default:"" in
  if List.exists (fun old -> Lines.starts_with old got) [ "octmip-proof 1"; "octmip-proof 2" ] then
    Lines.refuse 1 (Lines.shown got ^ " was written by an older octmip; write the log again");
  if got <> first then Lines.refuse 1 (Printf.sprintf "got %s, expected %S" (Lines.shown got) first);
  let check (name, digest, meaning) =
    let got = Option.value (Lines.read c) ~default:"" and expected = name ^ " " ^ digest in
    if got <> expected then
      let sentence = Printf.sprintf "got %s, expected %S of %s of the problem" (Lines.shown got) expected meaning in
      Lines.refuse c.n_read sentence
  in
  List.iter check
    [
      ("data", Problem.data_digest q, "the samples, labels and weights");
      ("question", Problem.question_digest q, "depth, costs, limits and sensors");
    ]

(* 2^-exponent in units of 2^-2148, as a quotient. *)
let unit_of exponent =
  let shift = (2 * Float64.least_exponent) - exponent in
  if shift >= 0 then (Z.shift_left Z.one shift, Z.one) else (Z.one, Z.shift_left Z.one (-shift))

(* A number times a power of two, rounded down. *)
let floor_of x exponent =
  let shift = exponent - Float64.least_exponent in
  let whole = Float64.exact x in
  if shift >= 0 then Z.shift_left whole shift else Z.shift_right whole (-shift)

let largest values = List.fold_left Z.max Z.zero values
let sum values = List.fold_left Z.add Z.zero values
let nats_of (q : Problem.t) labels = List.map (Question.nats (q.n_classes + most_own_rows)) labels

(* Weights, costs and penalty times powers of two, rounded down. *)
let read_rounded (q : Problem.t) c =
  let expected = "two exponents within 2200 (or \"unit\" and the numbers written out)" in
  match List.map Z.to_int (numbers c "grid" exponents 2 expected) with
  | [ a; b ] ->
      let floors exponent values = List.map (fun x -> floor_of x exponent) (Array.to_list values) in
      let weights = floors a q.weights and table = List.map (floors b) (Array.to_list q.costs) in
      let most = Z.mul (sum weights) (Z.max Z.one (largest (List.concat table))) in
      let is_small = Z.lt (largest weights) capacity && Z.lt (largest (List.concat table)) capacity in
      if not (is_small && Z.lt most capacity) then
        Lines.refuse c.n_read "on this grid a tree may cost 2^61 or more, which is beyond the checker's numbers";
      let up, down = unit_of (a + b) in
      {
        table;
        its_rows = nats_of q (Array.to_list q.labels);
        its_weights = weights;
        its_penalty = Z.min (floor_of q.penalty (a + b)) (Z.succ most);
        up;
        down;
        base = List.map (fun _ -> Z.zero) table;
        costs_line = Z.of_int c.n_read;
        penalty_line = Z.of_int c.n_read;
      }
  | _ -> assert false

let rec rows_of k values =
  match values with
  | [] -> []
  | _ -> List.filteri (fun i _ -> i < k) values :: rows_of k (List.filteri (fun i _ -> i >= k) values)

let check_table (q : Problem.t) line table =
  let k = q.n_classes and got = List.length table in
  let n_rows = got / k in
  if got <> n_rows * k || n_rows < k || n_rows > k + most_own_rows then
    Lines.refuse line
      (Printf.sprintf "got %d costs, expected rows of %d: from %d rows to %d" got k k (k + most_own_rows));
  n_rows

let check_rows (q : Problem.t) line n_rows rows =
  let n = Array.length q.labels in
  if List.length rows <> n || not (List.for_all (fun row -> Z.lt row (Z.of_int n_rows)) rows) then
    Lines.refuse line
      (Printf.sprintf "got %d rows of samples, expected %d below %d" (List.length rows) n n_rows)

let check_weights (q : Problem.t) line weights =
  let n = Array.length q.labels and got = List.length weights in
  if got <> n then Lines.refuse line (Printf.sprintf "got %d weights, expected %d" got n)

(* Sums that the other checker could not hold; to this one they are numbers like others. *)
let check_total line table rows weights =
  let most_of_row = Array.of_list (List.map largest table) in
  let total = sum (List.map2 (fun row weight -> Z.mul weight most_of_row.(Z.to_int row)) rows weights) in
  if Z.geq total capacity then
    Lines.refuse line
      (Printf.sprintf "with these weights a tree may cost %s, expected less than 2^61" (Z.to_string total))

(* Whole numbers as they stand in the log. *)
let read_written_out (q : Problem.t) c =
  let exponent = Z.to_int (List.hd (numbers c "unit" exponents 1 "one exponent within 2200")) in
  let list name = numbers c name wholes 0 "whole numbers below 2^61" in
  let table = list "costs" in
  let rows = list "rows" in
  let weights = list "weights" in
  let penalty = List.hd (numbers c "penalty" wholes 1 "one whole number below 2^61") in
  let line = c.n_read in
  let n_rows = check_table q (line - 3) table in
  check_rows q (line - 2) n_rows rows;
  check_weights q (line - 1) weights;
  let table = rows_of q.n_classes table and up, down = unit_of exponent in
  let cheapest own = Float64.exact (Array.fold_left Float.min Float.infinity own) in
  let numbers =
    {
      table;
      its_rows = nats_of q (List.map Z.to_int rows);
      its_weights = weights;
      its_penalty = penalty;
      up;
      down;
      base = List.map cheapest (Array.to_list q.costs);
      costs_line = Z.of_int (line - 1);
      penalty_line = Z.of_int line;
    }
  in
  (numbers, fun () -> check_total (line - 1) table rows weights)

(* Read a header. What it returns besides is a check that comes after those of the verified checker. *)
let read (q : Problem.t) c =
  check_identity q c;
  let is_written_out = match Lines.peek c with Some line -> Lines.starts_with "unit " line | None -> false in
  let found, check_total = if is_written_out then read_written_out q c else (read_rounded q c, ignore) in
  let claim = List.hd (numbers c "claim" wholes 1 "one whole number below 2^61") in
  check_total ();
  { numbers = found; claim }
