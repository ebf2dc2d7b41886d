#include "tests/world/judge/files_judge.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <iterator>

#include "config/text_file.hpp"
#include "daemon/control/access_list.hpp"
#include "daemon/control/audit_files.hpp"
#include "proto/control/access.hpp"
#include "proto/recording/recording.hpp"

namespace truepose::world {

namespace fs = std::filesystem;

namespace {

constexpr std::ptrdiff_t kKept = 20;  // recordings, by the cell file

}  // namespace

FilesJudge::FilesJudge(const fs::path& store, SoakLog& log)
    : audit_{daemon::audit_file_of(store)},
      access_{daemon::access_file_of(store)},
      log_{log},
      lists_{config::read_text_file(access_)} {}

void FilesJudge::change_access() {
  control::AccessEntries access = *control::read_access(lists_.back());
  access.entries.push_back({.name = fmt::format("user-{}", ++users_),
                            .role = control::Role::Viewer,
                            .salt = {},
                            .hash = {},
                            .certificate = fmt::format("{:064x}", users_)});
  lists_.push_back(control::access_text(access));
  try {
    config::write_text_file(access_, lists_.back());
    fs::permissions(access_, fs::perms::owner_read | fs::perms::owner_write);
    lists_.erase(lists_.begin(), lists_.end() - 1);
  } catch (const config::ConfigError&) {
  }
}

void FilesJudge::look() {
  look_at_audit();
  look_at_access();
  look_at_recording();
}

void FilesJudge::look_at_audit() {
  const auto report = daemon::verify_audit(audit_);
  if (!report) return log_.broken("the audit trail: " + report.error());
  for (const daemon::AuditFault& fault : report->faults)
    log_.broken("the audit trail was put aside: " + fault.text);
}

void FilesJudge::look_at_access() {
  const std::string list = fs::exists(access_) ? config::read_text_file(access_) : "";
  if (std::ranges::find(lists_, list) == lists_.end())
    log_.broken("the access list is none that was written: " + list);
}

void FilesJudge::look_at_recording() {
  if (recording_.empty()) return;
  if (!fs::exists(recording_)) {
    const auto others =
        std::distance(fs::directory_iterator{recording_.parent_path()}, fs::directory_iterator{});
    if (others < kKept) log_.broken(recording_.string() + " is lost");
    return recording_.clear();
  }
  const auto read = recording::Recording::read(config::read_bytes(recording_));
  if (!read) log_.broken(recording_.string() + ": " + read.error());
}

}  // namespace truepose::world
