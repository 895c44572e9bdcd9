// What is below that which drives, or beside it: drawn once that is shown.
import { Badge, InTurn } from "../../parts";
import { learn, t } from "../../words";
import { below } from "../../words/below";
import { CompassCard } from "./CompassCard";
import { Distances } from "./Distances";
import { Moves } from "./Moves";
import { gamepad, sideways } from "./pilot";
import { Songs } from "./Songs";
import { Speak } from "./Speak";

learn(below);

export default function Below({ drive }: { drive: string }) {
  return (
    <InTurn>
      <Moves drive={drive} />
      <Speak />
      <Distances />
      <Songs />
      <CompassCard />
      {gamepad.value ? <Badge icon="gamepad" tone="good">{t(sideways() ? "drive.gamepad.aside" : "drive.gamepad")}</Badge> : matchMedia("(pointer: fine)").matches && <p class="drive-keys muted">{t(sideways() ? "drive.keys.aside" : "drive.keys")}</p>}
    </InTurn>
  );
}
