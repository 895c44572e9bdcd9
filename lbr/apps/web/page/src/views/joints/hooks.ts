// What the views of joints and motions have in common: the stream of the joints, at the pace of a reader.
import { useEffect, useState } from "preact/hooks";
import { listen, type Sample } from "../../live";
import { streamOfType } from "../../robot";

/** The newest sample of a stream, no more than so often: lists need not follow each message. */
export function useCalm<T>(key: string, everyMs = 100): Sample<T> | null {
  const [sample, show] = useState<{ key: string; sample: Sample<T> } | null>(null);
  useEffect(() => {
    let timer: ReturnType<typeof setTimeout> | undefined;
    let shownAt = -Infinity;
    let newest: Sample<T> | null = null;
    const now = (): void => {
      timer = undefined;
      shownAt = performance.now();
      if (newest) show({ key, sample: newest });
    };
    const end = listen(key, (one) => {
      newest = one as Sample<T>;
      const wait = shownAt + everyMs - performance.now();
      if (wait <= 0 && timer === undefined) now();
      else timer ??= setTimeout(now, Math.max(0, wait));
    });
    return () => {
      end();
      clearTimeout(timer);
    };
  }, [key, everyMs]);
  return sample?.key === key ? sample.sample : null;
}

export const jointsStream = (): string => streamOfType("JointsState");
/** The capability that owns a stream. */
export const ownerOf = (stream: string): string => stream.split("/")[0] ?? "";
