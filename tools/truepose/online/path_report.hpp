#pragma once

#include "tools/truepose/online/online_commands.hpp"

namespace truepose::tools {

/// Reports a production program by a model file, without a campaign and its daemon: prints what the path
/// comes to (with `--json` the document) and writes the files asked for.
///
/// @param options  with path, robot and model
/// @return kDone. Throws CommandError: kFailed where the correction brought the arm no nearer; ConfigError
/// where a file cannot be used.
int report_path(const OnlineOptions& online, const ReportOptions& options);

}  // namespace truepose::tools
