(* The problem file that octmip solve --write-problem writes: its numbers in float64, and the digests that bind a log to
   it. *)

type t = {
  p : int;
  n_classes : int;
  readings : float option array array; (* by sample, then by feature *)
  labels : int array;
  weights : float array;
  costs : float array array; (* by class, then by label *)
  depth : int;
  leaf_size : int;
  penalty : float;
  sensor_of_feature : int array;
  sensor_cost : float array;
  sensor_limit : float;
  allowed : int list list option; (* groups of features that may meet in one split *)
}

exception Wrong of string

let wrong text = raise (Wrong text)
let most_depth = 30

let get file name =
  match file with
  | Json.Object entries -> (
      match List.assoc_opt name entries with
      | Some value -> value
      | None -> wrong (Printf.sprintf "the entry %S is missing" name))
  | _ -> wrong "the file holds no object"

let list name value = match value with Json.List values -> values | _ -> wrong (name ^ " is no list")
let number name value = match value with Json.Number x -> x | _ -> wrong (name ^ " holds what is no number")
let numbers name value = Array.of_list (List.map (number name) (list name value))

let whole name value =
  let x = number name value in
  if x >= 0.0 && x < 0x1p53 && Float.is_integer x then int_of_float x
  else wrong (Printf.sprintf "%s holds %s, expected a whole number" name (Float64.shown x))

let index name value =
  let x = whole name value in
  if x < 1 lsl 32 then x else wrong (Printf.sprintf "%s holds %d, expected a number below 2^32" name x)

let indices name value = Array.of_list (List.map (index name) (list name value))

let quoted value =
  match value with
  | Json.Text text -> Printf.sprintf "%S" (String.sub text 0 (min 40 (String.length text)))
  | _ -> "no text"

(* The kind of problem, or a sentence that says what this program checks. *)
let check_kind file =
  let format = get file "format" in
  if format = Json.Text "octmip-regression-problem" then
    wrong "the problem is one of regression, and the verified checker has classification trees only; run octmip-check";
  if format <> Json.Text "octmip-problem" then
    wrong (Printf.sprintf "format is %s, expected \"octmip-problem\"" (quoted format));
  let version = whole "version" (get file "version") in
  if version < 1 || version > 2 then wrong "version is not 1 to 2; a newer octmip wrote the file";
  match get file "split" with
  | Json.Text "axis" -> ()
  | Json.Text "hyperplane" ->
      wrong "the trees have hyperplane splits, and the verified checker has axis-aligned ones only; run octmip-check"
  | other -> wrong (Printf.sprintf "split is %s, expected \"axis\" or \"hyperplane\"" (quoted other))

let readings_of file =
  let takes_missing = whole "version" (get file "version") > 1 in
  let row i value =
    let name = Printf.sprintf "features[%d]" i in
    let reading value =
      match value with Json.Null when takes_missing -> None | value -> Some (number name value)
    in
    Array.of_list (List.map reading (list name value))
  in
  let rows = Array.of_list (List.mapi row (list "features" (get file "features"))) in
  let p = if Array.length rows = 0 then wrong "features[0] is no list" else Array.length rows.(0) in
  let check i own =
    if Array.length own <> p then
      wrong (Printf.sprintf "features[%d] has %d values, expected %d" i (Array.length own) p)
  in
  Array.iteri check rows;
  (p, rows)

let limit_of value =
  match value with Json.Null -> Float.infinity | value -> number "sensor_limit" value

let groups_of value =
  match value with
  | Json.Null -> None
  | value ->
      let group value = Array.to_list (indices "a group of allowed_splits" value) in
      Some (List.map group (list "allowed_splits" value))

let check_lengths q =
  let n = Array.length q.readings in
  let check (name, got, expected) =
    if got <> expected then wrong (Printf.sprintf "%s has %d entries, expected %d" name got expected)
  in
  List.iter check
    [
      ("labels", Array.length q.labels, n);
      ("weights", Array.length q.weights, n);
      ("sensor_of_feature", Array.length q.sensor_of_feature, q.p);
    ];
  let row own = check ("costs", Array.length own, q.n_classes) in
  Array.iter row q.costs

let check_ranges q split_size =
  let check (name, got, most) =
    if got < 1 || got > most then wrong (Printf.sprintf "%s is %d, expected 1 to %d" name got most)
  in
  List.iter check
    [
      ("n_features", q.p, max_int);
      ("n_classes", q.n_classes, max_int);
      ("depth", q.depth, most_depth);
      ("leaf_size", q.leaf_size, max_int);
      ("split_size", split_size, 1);
    ]

let check_numbers q =
  let check name x =
    if x < 0.0 then
      wrong (Printf.sprintf "%s holds %s, expected finite numbers of 0 or more" name (Float64.shown x))
  in
  Array.iter (check "weights") q.weights;
  Array.iter (Array.iter (check "costs")) q.costs;
  Array.iter (check "sensor_cost") q.sensor_cost;
  check "leaf_penalty" q.penalty;
  check "sensor_limit" q.sensor_limit

let check_indices q =
  let check name n index =
    if index >= n then wrong (Printf.sprintf "%s holds %d, expected indices below %d" name index n)
  in
  Array.iter (check "labels" q.n_classes) q.labels;
  Array.iter (check "sensor_of_feature" (Array.length q.sensor_cost)) q.sensor_of_feature;
  List.iter (List.iter (check "allowed_splits" q.p)) (Option.value q.allowed ~default:[])

let read text =
  let file = try Json.parse text with Json.Wrong reason -> wrong reason in
  check_kind file;
  let p, readings = readings_of file in
  let costs = List.map (numbers "a row of costs") (list "costs" (get file "costs")) in
  let q =
    {
      p;
      n_classes = List.length costs;
      readings;
      labels = indices "labels" (get file "labels");
      weights = numbers "weights" (get file "weights");
      costs = Array.of_list costs;
      depth = whole "depth" (get file "depth");
      leaf_size = whole "leaf_size" (get file "leaf_size");
      penalty = number "leaf_penalty" (get file "leaf_penalty");
      sensor_of_feature = indices "sensor_of_feature" (get file "sensor_of_feature");
      sensor_cost = numbers "sensor_cost" (get file "sensor_cost");
      sensor_limit = limit_of (get file "sensor_limit");
      allowed = groups_of (get file "allowed_splits");
    }
  in
  check_lengths q;
  check_ranges q (whole "split_size" (get file "split_size"));
  check_numbers q;
  check_indices q;
  q

let has_missing q = Array.exists (Array.exists Option.is_none) q.readings

(* Fields of a digest: name and length as text, numbers as 8 bytes each, the lowest first. *)
let field out name numbers =
  Buffer.add_string out (Printf.sprintf "%s %d\n" name (Array.length numbers));
  Array.iter (Buffer.add_int64_le out) numbers

let wholes out name values = field out name (Array.map Int64.of_int values)
let floats out name values = field out name (Array.map Int64.bits_of_float values)
let missing = 0x7ff8000000000000L

let data_digest q =
  let out = Buffer.create 65536 in
  let bits reading = match reading with Some x -> Int64.bits_of_float x | None -> missing in
  wholes out "shape" [| Array.length q.readings; q.p |];
  field out "features" (Array.concat (Array.to_list (Array.map (Array.map bits) q.readings)));
  wholes out "labels" q.labels;
  floats out "weights" q.weights;
  Sha256.hex (Buffer.contents out)

let question_digest q =
  let out = Buffer.create 4096 in
  wholes out "sizes" [| q.n_classes; q.depth; 0; 1; q.leaf_size |];
  floats out "costs" (Array.concat (Array.to_list q.costs));
  floats out "limits" [| q.penalty; q.sensor_limit |];
  wholes out "sensor_of_feature" q.sensor_of_feature;
  floats out "sensor_cost" q.sensor_cost;
  wholes out "is_limited" [| (if Option.is_some q.allowed then 1 else 0) |];
  List.iter (fun group -> wholes out "group" (Array.of_list group)) (Option.value q.allowed ~default:[]);
  Sha256.hex (Buffer.contents out)
