(* The lines of a log, read one after the other. *)

type t = { lines : string array; mutable n_read : int }

exception Refused of int * string

let refuse line reason = raise (Refused (line, reason))

(* Lines as Rust has them: the last may lack its end, and a return before the end belongs to it. *)
let of_text text =
  let stripped line =
    let n = String.length line in
    if n > 0 && line.[n - 1] = '\r' then String.sub line 0 (n - 1) else line
  in
  let all = String.split_on_char '\n' text in
  let all = match List.rev all with "" :: rest -> List.rev rest | _ -> all in
  { lines = Array.of_list (List.map stripped all); n_read = 0 }

let peek c = if c.n_read < Array.length c.lines then Some c.lines.(c.n_read) else None

let read c =
  let line = peek c in
  c.n_read <- c.n_read + 1;
  line

let starts_with prefix line =
  let n = String.length prefix in
  String.length line >= n && String.sub line 0 n = prefix

(* The first characters of a line, as they are shown in a reason. *)
let shown line =
  let is_start c = Char.code c land 0xc0 <> 0x80 in
  let n = ref 0 and stop = ref (String.length line) in
  String.iteri (fun i c -> if is_start c then (incr n; if !n = 81 then stop := i)) line;
  let escaped = Buffer.create 80 in
  let add c =
    match c with
    | '"' | '\\' -> Buffer.add_char escaped '\\'; Buffer.add_char escaped c
    | '\t' -> Buffer.add_string escaped "\\t"
    | '\r' -> Buffer.add_string escaped "\\r"
    | '\000' -> Buffer.add_string escaped "\\0"
    | c when c < ' ' || c = '\127' -> Buffer.add_string escaped (Printf.sprintf "\\u{%x}" (Char.code c))
    | c -> Buffer.add_char escaped c
  in
  String.iter add (String.sub line 0 !stop);
  "\"" ^ Buffer.contents escaped ^ "\""

let most_whole = Z.pred (Z.shift_left Z.one 63)

(* A whole number of 0 or more, in digits alone, of 64 bits at most. *)
let whole_number word =
  let is_digit c = c >= '0' && c <= '9' in
  if word = "" || not (String.for_all is_digit word) then None
  else if String.length word < 18 then Some (Z.of_int (int_of_string ("0u" ^ word)))
  else
    let value = Z.of_string word in
    if Z.leq value most_whole then Some value else None

(* The numbers of words; none if one is no number. *)
let rec all_numbers number words =
  match words with
  | [] -> Some []
  | word :: rest -> (
      match number word with
      | None -> None
      | Some value -> Option.map (fun others -> value :: others) (all_numbers number rest))

(* The numbers of the next line, if it has this tag and whole numbers of 0 or more; else it is not read. *)
let take c tag =
  match Option.map (String.split_on_char ' ') (peek c) with
  | Some (first :: words) when first = tag ->
      let numbers = all_numbers whole_number words in
      if Option.is_some numbers then c.n_read <- c.n_read + 1;
      numbers
  | _ -> None

(* The numbers of the next line, which must have this tag and so many numbers. *)
let expect c tag count =
  let got = Option.value (peek c) ~default:"" in
  let line = c.n_read + 1 in
  match take c tag with
  | Some numbers when List.length numbers = count -> numbers
  | _ -> refuse line (Printf.sprintf "got %s, expected %s and %d numbers" (shown got) tag count)

(* Check that the word "end" is all that is left. *)
let expect_end c =
  let got = read c in
  if got <> Some "end" then
    refuse c.n_read (Printf.sprintf "got %s, expected end" (shown (Option.value got ~default:"")));
  match peek c with
  | Some line -> refuse (c.n_read + 1) (Printf.sprintf "got %s after the end" (shown line))
  | None -> ()
