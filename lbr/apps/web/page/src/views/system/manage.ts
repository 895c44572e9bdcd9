// What the robot tells of its rows, tokens and logs, and what a change of rows would do.
import { fetchJson } from "../../robot";
import type { Answer } from "../../access";
import type { Schema } from "./schema";

export type Row = Record<string, unknown>;
export interface TableOf { table: string; rows: number; fixed: string }
export interface Table { table: string; key: string[]; fixed: string; schema: Schema; settings: Record<string, Schema>; rows: Row[] }
export interface RowProblem { table: string; row: string; column: string; text: string }
export interface Touched { start: string[]; stop: string[]; restart: string[]; plug: string[] }
export interface Reply<T> { accepted: boolean; reason: string; code: string; revision?: number; problems: RowProblem[]; touched: Touched | null; data: T }
export interface Token { name: string; role: string; created_at: string; revoked_at: string | null; expires_at: string | null; good_for: string; paired_from: string | null; called: string | null }
export interface RowChange { table: string; before: Row | null; after: Row | null }

export const tables = (): Promise<Answer<Reply<{ tables: TableOf[] }>>> => fetchJson("api/rows", { timeoutMs: 12_000 });
export const table = (name: string): Promise<Answer<Reply<Table>>> => fetchJson(`api/rows/${encodeURIComponent(name)}`, { timeoutMs: 12_000 });
export interface Device { place: string; address: string; name: string; serial: string; type: string; what: string; row: string; text: string }
export interface Offer { address: string; text: string; changes: RowChange[]; differences: string[]; problems: string[] }
export interface Looked { devices: Device[]; proposals: Offer[]; hints: string[] }
export const devices = (): Promise<Answer<Reply<Looked>>> => fetchJson("api/devices", { method: "POST", timeoutMs: 12_000 });
export const changeAll = (changes: RowChange[], write: boolean, quiet = false): Promise<Answer<Reply<null>>> =>
  fetchJson("api/rows", { method: "POST", body: { changes, write }, quiet, timeoutMs: 12_000 });
export const takeBack = (revision: number): Promise<Answer<Reply<null>>> => fetchJson("api/rows/undo", { method: "POST", body: { revision }, timeoutMs: 12_000 });
export const tokens = (): Promise<Answer<Reply<{ tokens: Token[] }>>> => fetchJson("api/tokens", { timeoutMs: 12_000 });
export const rename = (name: string, called: string): Promise<Answer<Reply<null>>> => fetchJson("api/tokens/rename", { method: "POST", body: { name, called }, timeoutMs: 12_000 });
export const revoke = (name: string): Promise<Answer<Reply<null>>> => fetchJson("api/tokens/revoke", { method: "POST", body: { name }, timeoutMs: 12_000 });
export const log = (name: string): Promise<Answer<Reply<{ name: string; text: string }>>> => fetchJson(`api/logs/${encodeURIComponent(name)}`, { timeoutMs: 12_000 });

/** What people call a token. */
export const calledOf = (token: Token): string => token.called || token.name;
/** Tokens by what people call them, those that are locked out last. */
export const inOrder = (all: Token[]): Token[] => [...all].sort((one, other) => Number(one.revoked_at !== null) - Number(other.revoked_at !== null) || calledOf(one).localeCompare(calledOf(other)));
export const nameOf = (of: Table, row: Row): string => of.key.map((column) => String(row[column])).join(" / ");
