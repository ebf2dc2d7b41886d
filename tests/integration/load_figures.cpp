#include "tests/integration/load_figures.hpp"

#include <boost/json/array.hpp>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>

namespace truepose {

namespace json = boost::json;

double resident_MB(pid_t process) {
  std::istringstream status{text_of("/proc/" + std::to_string(process) + "/status")};
  for (std::string word; status >> word;) {
    double kB = 0;
    if (word == "VmRSS:" && status >> kB) return kB / 1024;
  }
  throw std::runtime_error{"no VmRSS"};
}

namespace {

/// What the controller has seen of the wire so far: how many replies came after so many microseconds.
std::map<std::int64_t, std::int64_t> turnarounds(const json::value& rsi) {
  std::map<std::int64_t, std::int64_t> counts;
  for (const json::value& count : rsi.at_pointer("/turnaround_us/counts").as_array())
    counts[count.at(0).as_int64()] = count.at(1).as_int64();
  return counts;
}

}  // namespace

double p99_us(const json::value& before, const json::value& after) {
  std::map<std::int64_t, std::int64_t> counts = turnarounds(after);
  for (const auto& [us, count] : turnarounds(before)) counts[us] -= count;
  std::int64_t all = 0, seen = 0;
  for (const auto& [us, count] : counts) all += count;
  for (const auto& [us, count] : counts) {
    seen += count;
    if (100 * seen >= 99 * all) return static_cast<double>(us);
  }
  return 0;
}

}  // namespace truepose
