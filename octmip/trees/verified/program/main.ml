(* `octmip-verified LOG PROBLEM.json`: check a proof log against the problem file that octmip solve wrote, by the checker
   whose correctness is a theorem.

   Exit code 0: the log proves its bound. 1: it is refused, and one line says where and why. 2: a file cannot be used. *)

open Verified
module Z = Integer

let usage = "usage: octmip-verified LOG PROBLEM.json (files of octmip solve --proof and --write-problem)"

exception Fault of string

let read path expected =
  try let file = open_in_bin path in
    Fun.protect ~finally:(fun () -> close_in file) (fun () -> really_input_string file (in_channel_length file))
  with Sys_error reason ->
    raise (Fault (Printf.sprintf "%s; expected %s; check the path" reason expected))

let int_of nat =
  let rec count n nat = match nat with O -> n | S rest -> count (n + 1) rest in
  count 0 nat

let sentence (q : Problem.t) (header : Header.t) (body : Body.t) line why =
  let text = Z.to_string in
  match why with
  | CannotBeRead -> Option.value (Hashtbl.find_opt body.reasons (Z.to_int line)) ~default:"a record is missing"
  | OtherShape depth -> Printf.sprintf "expected depth %s, leaves of %d" (text depth) q.leaf_size
  | CheaperTree (cost, bound) -> Printf.sprintf "a tree costs %s, not %s" (text cost) (text bound)
  | CheaperCut (place, column, cost, bound) ->
      Printf.sprintf "cut %s of feature %d: %s, not %s" (text place) (int_of column) (text cost) (text bound)
  | NoSuchCut (column, place) ->
      let own = Z.of_int (int_of column) in
      let feature = Option.value (Hashtbl.find_opt body.strangers (Z.to_int line)) ~default:own in
      Printf.sprintf "feature %s has no cut %s here" (text feature) (text place)
  | ProvesLess (bound, claim) -> Printf.sprintf "this proves %s, not %s" (text bound) (text claim)
  | NoSuchSensor sensor -> Printf.sprintf "sensor %s cannot be decided here" (text sensor)
  | AboveTheTrueCost (sample, label) ->
      let numbers = header.numbers and i = int_of sample and k = int_of label in
      let row = List.nth numbers.table (int_of (List.nth numbers.its_rows i)) in
      let weight = text (List.nth numbers.its_weights i) and cost = text (List.nth row k) in
      Printf.sprintf "sample %d, class %d: %s x %s is above the true cost" i k weight cost
  | PenaltyAbove ->
      let penalty = text header.numbers.its_penalty in
      Printf.sprintf "the penalty %s is above the problem's, %s" penalty (Float64.shown q.penalty)
  | WrongLengths -> "there is not one row and one weight for each sample"

(* The bound that a log proves, rounded down, and its lines. *)
let proven (q : Problem.t) text =
  let cursor = Lines.of_text text in
  let header = Header.read q cursor in
  let log, body = Body.read q cursor in
  match check (Question.of_problem q) header.numbers header.claim log with
  | Refused (line, why) -> Lines.refuse (Z.to_int line) (sentence q header body line why)
  | Ok value ->
      Lines.expect_end cursor;
      (Float64.rounded_down (Z.div value header.numbers.down), Array.length cursor.lines)

let run log problem =
  let start = Sys.time () in
  let text = read log "a proof log of octmip solve --proof" in
  let file = read problem "a problem file of octmip solve --write-problem" in
  let q =
    try Problem.read file
    with Problem.Wrong reason ->
      let cure = "expected a problem file; write it again with octmip solve --write-problem" in
      raise (Fault (Printf.sprintf "%s: %s; %s" problem reason cure))
  in
  let bound, n_lines = proven q text in
  let seconds = Sys.time () -. start in
  Printf.printf "verified: no tree costs less than %s (%d lines, %.2f s)\n" (Float64.shown bound) n_lines seconds

let fault reason =
  prerr_endline ("octmip-verified: " ^ reason);
  exit 2

let () =
  Gc.set { (Gc.get ()) with minor_heap_size = 1 lsl 22; space_overhead = 400 };
  match Sys.argv with
  | [| _; log; problem |] -> (
      try run log problem with
      | Lines.Refused (line, reason) ->
          Printf.printf "%s, line %d: %s; the proof is refused\n" log line reason;
          exit 1
      | Fault reason -> fault reason
      | Stack_overflow -> fault "the samples or the log need a larger stack; say ulimit -s unlimited and run it again")
  | _ -> fault (Printf.sprintf "got %d arguments, expected 2; %s" (Array.length Sys.argv - 1) usage)
