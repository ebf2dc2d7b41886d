#pragma once

#include <string>

#include "proto/rpc/campaign.hpp"
#include "tools/truepose/online/rpc_client.hpp"

namespace truepose::tools {

/// The client's events from now on are those that watch_to_end() shows.
void subscribe_to_watch(RpcClient& client);

/// Follows a campaign to its end: shows how far it is, and what was tried again, skipped, waited for and
/// paused. Ctrl-C ends this program alone, and says how the campaign is followed or aborted. The client is
/// subscribed. Throws CommandError.
///
/// @param begun   progress that it has made so far
/// @param silent  shows nothing
/// @return its last progress
Received<rpc::CampaignProgress> watch_to_end(RpcClient& client, const rpc::CampaignProgress& begun,
                                             bool silent);

/// What a campaign has come to, by its last progress, and what to do next. Throws CommandError.
std::string ending_text(RpcClient& client, const rpc::CampaignProgress& progress);

}  // namespace truepose::tools
