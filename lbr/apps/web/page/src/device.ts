// What this device is called when it pairs: the robot numbers a name that another device has already.
const KINDS = [[/iPhone/, "iPhone"], [/iPad/, "iPad"], [/Android.*Mobile/, "Android phone"], [/Android/, "Android tablet"], [/CrOS/, "Chromebook"], [/Macintosh/, "Mac"], [/Windows/, "Windows PC"], [/Linux/, "Linux PC"]] as const;
const BROWSERS = [[/Edg/, "Edge"], [/OPR/, "Opera"], [/SamsungBrowser/, "Samsung Internet"], [/Firefox|FxiOS/, "Firefox"], [/Chrom|CriOS/, "Chrome"], [/Safari/, "Safari"]] as const;

const first = (of: readonly (readonly [RegExp, string])[], agent: string): string => of.find(([is]) => is.test(agent))?.[1] ?? "";

/** The kind of device and its browser, such as "Android phone Firefox". */
export const deviceName = (agent = navigator.userAgent): string => [first(KINDS, agent) || "device", first(BROWSERS, agent)].filter(Boolean).join(" ");
