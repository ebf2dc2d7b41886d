#pragma once

#include <filesystem>
#include <string>

#include "tools/truepose/online_commands.hpp"

namespace truepose::tools {

/// What a report is made of and where it goes. Empty paths are not read or written.
struct ReportOptions {
  std::string campaign;            ///< id; empty: the newest that is done
  std::filesystem::path document;  ///< a calibration document on a file instead of the daemon's
  std::filesystem::path truth;     ///< what a simulated arm really is, to stand beside what was identified
  std::filesystem::path iso9283, experiment;  ///< documents that the page gets sections of
  std::filesystem::path html, json;           ///< files to write
};

/// Reports a campaign: prints the table of errors (with `--json` the whole document) and writes the files
/// asked for. The document is that of `calibrate --json` with what was measured again and, where it runs, the
/// state of the stream. Fails (1) where the calibration did not converge or its validation is no better than
/// the nominal arm's.
int report_campaign(const OnlineOptions& online, const ReportOptions& options);

}  // namespace truepose::tools
