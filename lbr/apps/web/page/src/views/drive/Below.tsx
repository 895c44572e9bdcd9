// What is used now and then, below what drives: loaded once the rest is shown.
import { learn } from "../../words";
import { below } from "../../words/below";
import { CompassCard } from "./CompassCard";
import { Songs } from "./Songs";

learn(below);

export default function Below() {
  return <><Songs /><CompassCard /></>;
}
