// Where the repository is. (import.meta.dirname needs a newer Node.js than Debian 12 has.)
import { fileURLToPath } from "node:url";

export const root = fileURLToPath(new URL("../..", import.meta.url));
