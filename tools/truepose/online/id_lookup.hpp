#pragma once

#include <string>
#include <vector>

#include "tools/truepose/online/campaign_source.hpp"
#include "tools/truepose/online/online_commands.hpp"

namespace truepose::tools {

/// The id that a word stands for: itself, the only one that begins with it, or the newest for "latest".
///
/// @param of     what it is the id of: "campaign", "model" or "recording"
/// @param store  where campaigns are looked for instead of at the daemon, if it is given
/// Throws CommandError: kFailed where there is none, kBadInput where several begin with the word.
std::string whole_id(const OnlineOptions& online, const StoreFile& store, const std::string& of,
                     const std::string& word);

/// All of them and "latest", for a shell; none where no daemon answers.
std::vector<std::string> ids_to_choose(const OnlineOptions& online, const std::string& of);

}  // namespace truepose::tools
