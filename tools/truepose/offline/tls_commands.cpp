// A small CA for the cell: certificates of the daemon and of panels that are to be known by one.
#include <sys/stat.h>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <memory>

#include "config/text_file.hpp"
#include "proto/control/access.hpp"
#include "proto/control/certificate.hpp"
#include "proto/control/json_text.hpp"
#include "tools/truepose/offline/certificate_maker.hpp"
#include "tools/truepose/offline/offline_commands.hpp"

namespace truepose::tools {
namespace {

namespace fs = std::filesystem;

constexpr std::chrono::days kAuthorityValid{3650}, kCertificateValid{730};

struct TlsCommand {
  fs::path folder;
  std::vector<std::string> hosts;
  std::string name;
};

fs::path ca_file(const fs::path& folder) { return folder / "ca.pem"; }
fs::path ca_key_file(const fs::path& folder) { return folder / "ca.key"; }

/// Certificate and key; only we can read the key.
void write(const Identity& identity, const fs::path& certificate, const fs::path& key) {
  const mode_t usual = ::umask(0077);
  config::write_text_file(key, pem_of(*identity.key));
  ::umask(usual);
  config::write_text_file(certificate, pem_of(*identity.certificate));
}

Identity load_authority(const fs::path& folder) {
  Identity authority{certificate_in(config::read_text_file(ca_file(folder))),
                     key_in(config::read_text_file(ca_key_file(folder)))};
  if (!authority.certificate || !authority.key)
    throw CommandError{kBadInput, folder.string() + ": ca.pem or ca.key is no certificate or no key"};
  return authority;
}

std::string valid_until(const Identity& identity) {
  return control::rfc3339(control::facts_of(*identity.certificate).until);
}

int run_init(const TlsCommand& command) {
  fs::create_directories(command.folder);
  if (!fs::exists(ca_key_file(command.folder)))
    write(new_authority("truepose CA", kAuthorityValid), ca_file(command.folder),
          ca_key_file(command.folder));
  const Identity authority = load_authority(command.folder);
  // A name of the certificate is no longer than that; what clients compare are the hosts.
  constexpr std::size_t kLongestName = 64;
  const std::string& host = command.hosts.front();
  const Identity daemon = new_identity({.name = host.size() <= kLongestName ? host : "truepose",
                                        .hosts = command.hosts,
                                        .usage = "serverAuth",
                                        .valid = kCertificateValid},
                                       authority);
  write(daemon, command.folder / "daemon.pem", command.folder / "daemon.key");
  std::printf("%s: of the daemon, until %s\n%s: what clients know it by (--tls-ca)\n",
              (command.folder / "daemon.pem").c_str(), valid_until(daemon).c_str(),
              ca_file(command.folder).c_str());
  return kDone;
}

int run_client(const TlsCommand& command) {
  std::string file = command.name;
  std::ranges::replace_if(
      file, [](unsigned char c) { return std::isalnum(c) == 0; }, '-');
  const fs::path certificate = command.folder / (file + ".pem"), key = command.folder / (file + ".key");
  if (fs::exists(certificate) || fs::exists(key))
    throw CommandError{kFailed, certificate.string() + " is there already; remove it and its key first"};
  const Identity client =
      new_identity({.name = command.name, .hosts = {}, .usage = "clientAuth", .valid = kCertificateValid},
                   load_authority(command.folder));
  write(client, certificate, key);
  std::printf("%s: until %s; let it in by `truepose access add NAME --certificate %s`\n", certificate.c_str(),
              valid_until(client).c_str(), certificate.c_str());
  return kDone;
}

Option folder_option(TlsCommand& command) {
  return {"--dir",
          &command.folder,
          "Folder of the cell's CA and certificates",
          {.required = true, .type = "DIR"}};
}

/// What would be more than a name in a certificate.
std::string host_fault(const std::string& host) {
  constexpr std::size_t kLongest = 253;  // RFC 1035
  const bool fits =
      !host.empty() && host.size() <= kLongest && std::ranges::all_of(host, [](unsigned char c) {
        return std::isalnum(c) != 0 || c == '.' || c == '-' || c == ':';
      });
  return fits ? "" : "expected a host's name of at most 253 characters, or an IP address";
}

}  // namespace

Command tls_commands() {
  return {.name = "tls", .help = "Certificates for the control port", .task = Task::Cell};
}

Command tls_init_command() {
  const auto command = std::make_shared<TlsCommand>();
  TlsCommand& c = *command;
  return {
      .name = "tls init",
      .help = "Makes the cell's CA where there is none, and a certificate of the daemon, new each time",
      .options = {folder_option(c),
                  Option(
                      "--host", &c.hosts, "Name or IP address that clients call the daemon by",
                      {.required = true, .check = Check{"", host_fault}, .type = "HOST", .repeats = true})},
      .run = [command] { return run_init(*command); },
      .examples = {{"tls init --dir tls --host cell.example"}}};
}

Command tls_client_command() {
  const auto command = std::make_shared<TlsCommand>();
  TlsCommand& c = *command;
  return {.name = "tls client",
          .help = "Makes a certificate by which the daemon knows a person or a panel",
          .options = {Option("NAME", &c.name, "Person or panel",
                             {.required = true, .check = Check{"", control::access_name_fault}}),
                      folder_option(c)},
          .run = [command] { return run_client(*command); },
          .examples = {{"tls client panel --dir tls"}}};
}

}  // namespace truepose::tools
