/** Node 18 has Web Crypto, which the packages look for, under another name. Imported before them. */
import { webcrypto } from "node:crypto";

globalThis.crypto ??= webcrypto;
