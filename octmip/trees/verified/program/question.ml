(* A problem as the verified checker takes it: readings as ranks, weights and costs as whole numbers, exactly. *)

open Verified
module Z = Integer

let nat n =
  let rec go found n = if n = 0 then found else go (S found) (n - 1) in
  go O n

(* Leaves of more samples than there are forbid every split, however many more. *)
let most_leaf_size = 100_000

(* Small numbers are shared, so that lists of them take no more room than lists of machine words. *)
let nats count =
  let all = Array.make (count + 1) O in
  for i = 1 to count do all.(i) <- S all.(i - 1) done;
  fun i -> all.(i)

(* The rank of each reading of a feature among the different ones. 0.0 and -0.0 are equal. *)
let ranks readings =
  let values = List.sort_uniq Float.compare (List.filter_map (Option.map (fun x -> x +. 0.0)) readings) in
  let rank_of = Hashtbl.create 1024 in
  List.iteri (fun rank value -> Hashtbl.replace rank_of value (Z.of_int rank)) values;
  List.map (Option.map (fun x -> Hashtbl.find rank_of (x +. 0.0))) readings

let rows (q : Problem.t) =
  let class_of = nats q.n_classes in
  let column f = Array.of_list (ranks (Array.to_list (Array.map (fun own -> own.(f)) q.readings))) in
  let columns = Array.init q.p column in
  let row i =
    let readings = List.init q.p (fun f -> columns.(f).(i)) in
    { readings; class0 = class_of q.labels.(i); weight = Float64.exact q.weights.(i) }
  in
  List.init (Array.length q.readings) row

let is_allowed (q : Problem.t) f =
  match q.allowed with None -> true | Some groups -> List.exists (List.mem f) groups

let of_problem (q : Problem.t) =
  let exact own = List.map Float64.exact (Array.to_list own) in
  {
    rows = rows q;
    n_classes = nat q.n_classes;
    costs = List.map exact (Array.to_list q.costs);
    split_penalty = Z.shift_left (Float64.exact q.penalty) Float64.least_exponent;
    depth = nat q.depth;
    fewest = nat (min q.leaf_size (max (Array.length q.readings + 1) most_leaf_size));
    sensors = List.map nat (Array.to_list q.sensor_of_feature);
    sensor_costs = exact q.sensor_cost;
    budget = (if q.sensor_limit = Float.infinity then None else Some (Float64.exact q.sensor_limit));
    allowed = List.init q.p (is_allowed q);
  }
