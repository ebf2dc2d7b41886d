/** The OPC UA server itself: who may connect, and how. What it shows is made elsewhere. */
import { X509Certificate } from "node:crypto";
import { readFile, readdir, stat } from "node:fs/promises";
import os from "node:os";
import path from "node:path";
import {
  MessageSecurityMode,
  OPCUACertificateManager,
  OPCUAServer,
  SecurityPolicy,
  UAUserManagerBase,
  makeApplicationUrn,
  nodesets,
} from "node-opcua";
import { OptionError } from "./options.mjs";

const NAMESPACE = "urn:truepose:opcua";
const PRODUCT = "truepose-opcua";
const MOST_SESSIONS = 20; // the daemon has room for 24 of ours
const MOST_CONNECTIONS = MOST_SESSIONS + 10; // who only looks at the endpoints, or is refused, has no session

/** Users are those of the control port: name and token, which the daemon judges. */
class Users extends UAUserManagerBase {
  #sessions;
  #log;

  constructor(sessions, log) {
    super();
    [this.#sessions, this.#log] = [sessions, log];
  }

  async isValidUser(session, name, token) {
    try {
      await this.#sessions.enter(session, name, token);
      return true;
    } catch (error) {
      this.#log(`user ${JSON.stringify(name)} was not let in: ${error.message}`);
      return false;
    }
  }

  getUserRoles() {
    return [];
  }
}

function policiesOf(names) {
  return names.map((name) => {
    const policy = SecurityPolicy[name];
    if (!policy || name === "Invalid" || name === "None")
      throw new OptionError(`--policies: '${name}' is no security policy that encrypts, such as Basic256Sha256`);
    return policy;
  });
}

/** @returns whether a file of the folder is that certificate; what is none, the library passes over too */
async function holds(folder, certificate) {
  for (const name of await readdir(folder)) {
    const { raw } = await readFile(path.join(folder, name)).then((file) => new X509Certificate(file)).catch(() => ({}));
    // Only what lies here is parsed: the other one is a stranger's, and may be anything.
    if (raw?.equals(certificate.subarray(0, raw.length))) return true;
  }
  return false;
}

/** @returns what changes when a file is put into one of the folders, replaced there or taken out */
async function stateOf(folders) {
  const files = await Promise.all(
    folders.map(async (folder) => (await readdir(folder)).sort().map((name) => path.join(folder, name))),
  );
  const describe = async (file) => {
    const { mtimeMs, size } = await stat(file).catch(() => ({}));
    return [file, mtimeMs, size];
  };
  return JSON.stringify(await Promise.all(files.flat().map(describe)));
}

/**
 * The files decide, not what the library remembers of them: its watchers miss a file that is moved while they start,
 * and a client that went on trying meanwhile would have its certificate moved back among the rejected ones.
 */
class CertificateStore extends OPCUACertificateManager {
  #turn = Promise.resolve();
  #known;

  /** One at a time: while the files are read, the library knows no certificate. */
  async verifyCertificateAsync(certificate, options) {
    const turn = this.#turn.then(async () => {
      await this.#readChanges();
      return super.verifyCertificateAsync(certificate, options);
    });
    this.#turn = turn.catch(() => {});
    return turn;
  }

  async rejectCertificate(certificateOrChain) {
    const [certificate] = [certificateOrChain].flat();
    if (!(await holds(this.trustedFolder, certificate))) await super.rejectCertificate(certificateOrChain);
  }

  async #readChanges() {
    const found = await stateOf([this.trustedFolder, this.crlFolder, this.issuersCertFolder, this.issuersCrlFolder]);
    if (found === this.#known) return;
    await this.reloadCertificates();
    this.#known = found;
  }
}

/** @returns the certificates that are trusted and those that were rejected, as they lie in the folder */
export async function storeOf(folder) {
  const store = new CertificateStore({
    rootFolder: folder,
    automaticallyAcceptUnknownCertificate: false,
    disableFileWatchers: true,
  });
  await store.initialize();
  return store;
}

/**
 * @param options  as readOptions() returns them
 * @param users    UserSessions
 * @param log      of one sentence
 * @returns the server, initialised and not yet started, with the companion specifications' types loaded
 */
export async function makeServer(options, users, log) {
  const { host, port } = options.listen;
  const server = new OPCUAServer({
    host,
    port,
    hostname: host === "0.0.0.0" || host === "::" ? os.hostname() : host,
    resourcePath: "/truepose",
    serverInfo: {
      applicationUri: makeApplicationUrn(os.hostname(), PRODUCT),
      productUri: PRODUCT,
      applicationName: { text: PRODUCT },
    },
    buildInfo: { productName: PRODUCT, manufacturerName: "truepose" },
    nodeset_filename: [nodesets.standard, nodesets.di, nodesets.ia, nodesets.robotics],
    securityPolicies: policiesOf(options.policies),
    securityModes: [MessageSecurityMode.SignAndEncrypt],
    allowAnonymous: options.anonymous,
    serverCertificateManager: await storeOf(options.pki),
    // Nobody is known by a certificate of a user: the key that the daemon wants to see is not here.
    userCertificateManager: await storeOf(path.join(options.pki, "users")),
    userManager: new Users(users, log),
    isAuditing: true,
    maxConnectionsPerEndpoint: MOST_CONNECTIONS,
    serverCapabilities: { maxSessions: MOST_SESSIONS },
  });
  server.on("session_closed", (session) => users.release(session));
  await server.initialize();
  return server;
}

/** @returns the namespace of all that is ours */
export const ownNamespace = (server) => server.engine.addressSpace.registerNamespace(NAMESPACE);
