#include "tools/truepose/online/id_lookup.hpp"

#include <algorithm>
#include <filesystem>
#include <vector>

#include "proto/rpc/model.hpp"
#include "proto/rpc/recording.hpp"
#include "tools/truepose/online/rpc_client.hpp"
#include "tools/truepose/text.hpp"

namespace truepose::tools {
namespace {

struct Candidate {
  std::string id;
  std::string what;  ///< by which it differs from others: "calibration, 2026-01-31 12:00:00"
};

/// All pages of a list, newest first.
/// @param next  gives the page from a number on, and how many there are in all
std::vector<Candidate> all_pages(const auto& next) {
  std::vector<Candidate> all;
  for (;;) {
    const auto [page, total] = next(all.size());
    all.insert(all.end(), page.begin(), page.end());
    if (page.empty() || all.size() >= static_cast<std::size_t>(total)) return all;
  }
}

using Page = std::pair<std::vector<Candidate>, int>;

std::vector<Candidate> campaigns(const OnlineOptions& online, const StoreFile& store) {
  const auto source = campaign_source(online, store);
  return all_pages([&](std::uint64_t offset) {
    const rpc::CampaignList::Result list = source->ask(rpc::CampaignList{.offset = offset}).record;
    std::vector<Candidate> page;
    for (const auto& each : list.campaigns)
      page.push_back({each.id, each.kind + ", " + shown_time(each.started)});
    return Page{page, list.total};
  });
}

std::vector<Candidate> models(const OnlineOptions& online) {
  RpcClient client = value_or_throw(RpcClient::connect(online));
  return all_pages([&](std::uint64_t offset) {
    const rpc::ModelList::Result list = value_or_throw(client.call(rpc::ModelList{.offset = offset})).record;
    std::vector<Candidate> page;
    for (const auto& each : list.models) page.push_back({each.id, "made " + shown_time(each.created)});
    return Page{page, list.total};
  });
}

std::vector<Candidate> recordings(const OnlineOptions& online) {
  RpcClient client = value_or_throw(RpcClient::connect(online));
  std::vector<Candidate> all;
  for (const auto& each : value_or_throw(client.call(rpc::RecordingList{})).record.recordings)
    all.push_back({each.name, each.reason});
  return all;
}

std::vector<Candidate> all_of(const OnlineOptions& online, const StoreFile& store, const std::string& of) {
  if (of == "campaign") return campaigns(online, store);
  return of == "model" ? models(online) : recordings(online);
}

bool is_whole(const std::string& word) {
  constexpr std::size_t kUuid = 36;
  return word.size() == kUuid && std::ranges::count(word, '-') == 4;
}

}  // namespace

std::string whole_id(const OnlineOptions& online, const StoreFile& store, const std::string& of,
                     const std::string& word) {
  if (is_whole(word)) return word;
  if (of != "recording" && std::filesystem::path{word}.has_extension())
    throw bad_usage(word + ": is a file, and the id of a " + of +
                    " is expected. Give one, its start, or latest");
  const std::vector<Candidate> all = all_of(online, store, of);
  const std::string see = ". See truepose " + of + " list";
  if (word == "latest") {
    if (all.empty()) throw CommandError{kFailed, "there is no " + of + " yet"};
    return all.front().id;
  }
  std::vector<Candidate> found;
  for (const Candidate& each : all) {
    if (each.id == word) return word;
    if (each.id.starts_with(word)) found.push_back(each);
  }
  if (found.empty())
    throw CommandError{kFailed, "no " + of + " has an id that begins with '" + word + "'" + see};
  if (found.size() == 1) return found.front().id;
  std::string names;
  for (const auto& [id, what] : found) names += (names.empty() ? "" : "; ") + id + " (" + what + ")";
  throw CommandError{kBadInput, "the ids of " + std::to_string(found.size()) + " " + of + "s begin with '" +
                                    word + "': " + names + ". Give more of it"};
}

std::vector<std::string> ids_to_choose(const OnlineOptions& online, const std::string& of) try {
  std::vector<std::string> ids{"latest"};
  for (const Candidate& each : all_of(online, {}, of)) ids.push_back(each.id);
  return ids;
} catch (const CommandError&) {
  return {};
}

}  // namespace truepose::tools
