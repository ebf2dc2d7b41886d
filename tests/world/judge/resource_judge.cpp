#include "tests/world/judge/resource_judge.hpp"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <iterator>
#include <string>

#include "tests/world/heap_count.hpp"

namespace truepose::world {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

namespace {

constexpr std::int64_t kGrowth_bytes = 8'000'000, kGrowth_descriptors = 20;
constexpr std::int64_t kLeft_bytes = 1'000'000;  // after any number of lives

}  // namespace

void ResourceJudge::begun() {
  begun_ = log_.now();
  settled_bytes_ = settled_descriptors_ = 0;
}

void ResourceJudge::look() {
  if (!cell_.pc.runs() || log_.now() - looked_ < 1min) return;
  looked_ = log_.now();
  const std::int64_t bytes = daemon_heap_bytes().value_or(0), descriptors = this->descriptors();
  largest_bytes = std::max(largest_bytes, bytes);
  if (looked_ - begun_ < 4h) {
    settled_bytes_ = std::max(settled_bytes_, bytes);
    settled_descriptors_ = std::max(settled_descriptors_, descriptors);
    return;
  }
  judge("bytes of memory", bytes, settled_bytes_, kGrowth_bytes);
  judge("descriptors", descriptors, settled_descriptors_, kGrowth_descriptors);
}

void ResourceJudge::judge(const std::string& what, std::int64_t now, std::int64_t& settled,
                          std::int64_t growth) {
  if (now <= settled + growth) return;
  log_.broken("the daemon had " + std::to_string(settled) + " " + what + ", and has " + std::to_string(now));
  settled = now;
}

void ResourceJudge::ended() {
  const std::int64_t left = daemon_heap_bytes().value_or(0);
  largest_left_bytes = std::max(largest_left_bytes, left);
  if (left > kLeft_bytes)
    log_.broken("of a daemon that has ended " + std::to_string(left) + " bytes are left");
}

std::int64_t ResourceJudge::descriptors() const {
  const auto open = std::distance(fs::directory_iterator{"/proc/self/fd"}, fs::directory_iterator{});
  return open - static_cast<std::int64_t>(cell_.pc.open_files());
}

}  // namespace truepose::world
