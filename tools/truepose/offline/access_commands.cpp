// Who may open sessions at the control port. The file is changed here, and read again by a daemon that runs.
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>

#include "config/cell_config.hpp"
#include "config/text_file.hpp"
#include "daemon/control/access_list.hpp"
#include "daemon/store/as_owner.hpp"
#include "proto/control/certificate.hpp"
#include "tools/truepose/offline/offline_commands.hpp"
#include "tools/truepose/text.hpp"

namespace truepose::tools {
namespace {

namespace fs = std::filesystem;
using control::AccessEntries;

struct AccessCommand {
  std::string cell_file, name, role;
  fs::path certificate;
};

[[noreturn]] void fail(const fs::path& file) {
  throw CommandError{kBadInput, "access file " + file.string() + ": " + std::strerror(errno)};
}

/// The access file of a cell, one change at a time: others wait meanwhile.
class AccessFile {
 public:
  explicit AccessFile(const std::string& cell_file)
      : file_{daemon::access_file_of(config::load_cell(cell_file).store)}, folder_{open_folder()} {
    auto read = daemon::read_access_file(file_);
    if (!read) throw CommandError{kBadInput, read.error()};
    access = *std::move(read);
  }
  AccessFile(const AccessFile&) = delete;
  AccessFile& operator=(const AccessFile&) = delete;
  ~AccessFile() { ::close(folder_); }

  const fs::path& path() const { return file_; }
  void write() const {
    const auto owner = daemon::AsOwnerOf::take(config::folder_of(file_));
    if (!owner) throw CommandError{kBadInput, "access file " + file_.string() + ": " + owner.error()};
    ::umask(0077);
    config::write_text_file(file_, control::access_text(access));
  }

  AccessEntries access;

 private:
  int open_folder() const {
    const int folder = ::open(config::folder_of(file_).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (folder < 0 || ::flock(folder, LOCK_EX) != 0) fail(file_);
    return folder;
  }

  fs::path file_;
  int folder_;
};

control::AccessEntry entry_by_certificate(const AccessCommand& command, const AccessEntries& access) {
  const auto certificate = control::read_certificate(config::read_text_file(command.certificate));
  if (!certificate) throw CommandError{kBadInput, command.certificate.string() + ": " + certificate.error()};
  if (const std::string fault = control::validity_fault(*certificate, std::chrono::system_clock::now());
      !fault.empty())
    throw CommandError{kFailed, command.certificate.string() + ": the certificate " + fault};
  if (const auto* const other = access.of_certificate(certificate->fingerprint))
    throw CommandError{kFailed, command.certificate.string() + ": is that of " + other->name};
  return {.name = command.name,
          .role = value_of(control::kRoles, command.role),
          .salt = {},
          .hash = {},
          .certificate = certificate->fingerprint};
}

int run_add(const AccessCommand& command) {
  AccessFile file{command.cell_file};
  if (file.access.named(command.name))
    throw CommandError{kFailed, command.name + " is in " + file.path().string() +
                                    " already; for another role or token, revoke it first"};
  const std::string token = command.certificate.empty() ? control::new_access_token() : "";
  file.access.entries.push_back(
      token.empty() ? entry_by_certificate(command, file.access)
                    : control::entry_for_token(command.name, value_of(control::kRoles, command.role), token));
  file.write();
  if (token.empty()) return kDone;
  std::printf("%s\n", token.c_str());
  print_to_stderr("truepose: the token of " + command.name + " is kept nowhere: it is not shown again");
  return kDone;
}

int run_list(const AccessCommand& command) {
  const AccessFile file{command.cell_file};
  std::vector<Cells> rows;
  for (const control::AccessEntry& entry : file.access.entries)
    rows.push_back({entry.name, std::string{control::name(entry.role)}});
  std::printf("%s", text_table(rows).c_str());
  return kDone;
}

int run_revoke(const AccessCommand& command) {
  AccessFile file{command.cell_file};
  const auto taken =
      std::erase_if(file.access.entries, [&](const auto& e) { return e.name == command.name; });
  if (taken == 0) throw CommandError{kFailed, "no " + command.name + " in " + file.path().string()};
  file.write();
  return kDone;
}

Option cell_option(AccessCommand& command) {
  return {"--cell", &command.cell_file, "Cell file", {.required = true, .file = FileUse::Read}};
}

Option name_option(AccessCommand& command) {
  return {"NAME", &command.name, "Person or panel", {.required = true}};
}

}  // namespace

Command access_commands() {
  return {.name = "access", .help = "Who may use the control port, and for what", .task = Task::Cell};
}

Command access_add_command() {
  const auto command = std::make_shared<AccessCommand>();
  AccessCommand& c = *command;
  Option name = name_option(c);
  name.rules.check = Check{"", control::access_name_fault};
  return {.name = "access add",
          .help = "Gives a client access: prints a token for it, or takes its certificate",
          .options = {name,
                      Option("--role", &c.role, "What it may do",
                             {.required = true, .check = available(names_of(control::kRoles))}),
                      Option("--certificate", &c.certificate,
                             "It is known by this certificate (PEM), over TLS, and by no token",
                             {.file = FileUse::Read}),
                      cell_option(c)},
          .run = [command] { return run_add(*command); },
          .examples = {{"access add anna --role engineer --cell cell.yaml"}}};
}

Command access_list_command() {
  const auto command = std::make_shared<AccessCommand>();
  return {.name = "access list",
          .help = "Names and roles",
          .options = {cell_option(*command)},
          .run = [command] { return run_list(*command); },
          .examples = {{"access list --cell cell.yaml"}}};
}

Command access_revoke_command() {
  const auto command = std::make_shared<AccessCommand>();
  return {.name = "access revoke",
          .help = "Revokes a client's access; a daemon that runs closes its sessions within 2 s",
          .options = {name_option(*command), cell_option(*command)},
          .run = [command] { return run_revoke(*command); },
          .examples = {{"access revoke anna --cell cell.yaml"}}};
}

}  // namespace truepose::tools
