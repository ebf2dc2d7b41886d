#pragma once

#include <filesystem>
#include <random>
#include <string>
#include <vector>

namespace truepose::test {

/// What has a daemon note what a power cut may take, for LiveCell::start_daemon().
std::vector<std::string> power_may_be_cut(const std::filesystem::path& store);

/// After the daemon was killed: takes from the files of its store what was written and not synced, by chance
/// some of it or all, in the order of writing or not, and one write torn at a sector.
/// @return how many writes there were
int cut_power(const std::filesystem::path& store, std::mt19937_64& random);

}  // namespace truepose::test
