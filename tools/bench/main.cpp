#include <benchmark/benchmark.h>

#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include "core/kernels/dispatch.hpp"
#include "tools/bench/jobs.hpp"

namespace {

/// What the table compares: the medians of two jobs, and by how much ours has to be faster.
struct Comparison {
  std::string job;
  const char* peer_name;
  std::string peer, ours;
  double goal;
};

std::vector<Comparison> comparisons() {
  std::vector<Comparison> rows{
      {"forward kinematics, one call", "KDL recursive", "forward/kdl", "forward/truepose", 5},
      {"forward kinematics, batch", "KDL recursive", "forward/kdl", "forward_batch/truepose", 15},
      {"pose and Jacobian", "KDL (Jacobian alone)", "jacobian/kdl", "jacobian/truepose", 12}};
  const struct {
    const char *points, *job;
    double goal_auto, goal_tuned;
  } sizes[]{{"/30", "identification, 30 points", 25, 4},
            {"/100", "identification, 100 points", 40, 6},
            {"/300", "identification, 300 points", 45, 8},
            {"/1000", "identification, 1000 points", 45, 8}};
  for (const auto& size : sizes) {
    const std::string points = size.points;
    rows.push_back({size.job, "Ceres AutoDiff, QR", "identify/ceres_auto" + points,
                    "identify/truepose" + points, size.goal_auto});
    rows.push_back({size.job, "Ceres analytic, tuned", "identify/ceres_tuned" + points,
                    "identify/truepose" + points, size.goal_tuned});
    rows.push_back({std::string(size.job).replace(0, 14, "all of calibrate()"), "Ceres AutoDiff, fit alone",
                    "identify/ceres_auto" + points, "calibrate/truepose" + points, 3});
  }
  const std::string each_target = "/iterations:10000";
  rows.push_back({"inverse of the calibrated arm", "KDL NR_JL", "inverse/kdl_nr_jl" + each_target,
                  "inverse/truepose" + each_target, 20});
  rows.push_back({"inverse of the calibrated arm", "KDL LMA", "inverse/kdl_lma" + each_target,
                  "inverse/truepose" + each_target, 35});
  rows.push_back({"compensation of joints", "Newton", "compensation/newton/regular",
                  "compensation/truepose/regular", 1});
  rows.push_back({"the same, next to A5 = 0", "Newton, unbounded", "compensation/newton/damped",
                  "compensation/truepose/damped", 0.4});
  rows.push_back({"RSI datagram in, answer out", "TinyXML 1", "rsi/tinyxml", "rsi/truepose", 15});
  rows.push_back({"RSI datagram in, answer out", "pugixml", "rsi/pugixml", "rsi/truepose", 5});
  rows.push_back(
      {"50 of 2000 poses, D-optimal", "determinants", "design/naive/iterations:1", "design/truepose", 150});
  rows.push_back(
      {"50 of 2000 poses, D-optimal", "rank-three updates", "design/rank_three", "design/truepose", 15});
  return rows;
}

/// What a job may take at most: its median.
struct Limit {
  std::string job, ours;
  double limit_ns;
};

std::vector<Limit> limits() {
  std::vector<Limit> rows;
  // What a real-time cycle has for it.
  rows.push_back({"residual field over 300 poses, one pose", "residual/gp", 20e3});
  rows.push_back({"KRL program of 100,000 points, text to text", "program/truepose/iterations:1", 5e9});
  return rows;
}

/// Collects the medians and how many targets were reached.
class Medians : public benchmark::BenchmarkReporter {
 public:
  bool ReportContext(const Context&) override { return true; }
  void ReportRuns(const std::vector<Run>& runs) override {
    for (const Run& run : runs) {
      if (run.error_occurred) {
        std::fprintf(stderr, "%s: %s\n", run.run_name.str().c_str(), run.error_message.c_str());
        failed_ = true;
      }
      if (run.aggregate_name != "median") continue;
      // Aggregates are in the run's unit, a nanosecond here.
      nanoseconds_[run.run_name.function_name + (run.run_name.args.empty() ? "" : "/" + run.run_name.args) +
                   (run.run_name.iterations.empty() ? "" : "/" + run.run_name.iterations)] =
          run.GetAdjustedCPUTime();
      if (const auto reached = run.counters.find("reached"); reached != run.counters.end())
        std::printf("%-20s %5.0f of 10000 targets within 1e-5 mm and 1e-8 rad\n",
                    run.run_name.function_name.c_str(), reached->second.value);
    }
  }

  /// Prints the tables as Markdown.
  /// @return whether every goal is reached
  bool print() const {
    const bool ratios = print_comparisons(), times = print_limits();
    return ratios && times && !failed_;
  }

 private:
  bool print_comparisons() const {
    bool reached = true;
    std::printf("\n| job | peer | peer | truepose | ratio | goal |\n|---|---|--:|--:|--:|--:|\n");
    for (const Comparison& row : comparisons()) {
      const auto peer = nanoseconds_.find(row.peer), ours = nanoseconds_.find(row.ours);
      if (peer == nanoseconds_.end() || ours == nanoseconds_.end()) continue;
      const double ratio = peer->second / ours->second;
      reached = reached && ratio >= row.goal;
      std::printf("| %s | %s | %s | %s | %.1f | %g |\n", row.job.c_str(), row.peer_name,
                  time(peer->second).c_str(), time(ours->second).c_str(), ratio, row.goal);
    }
    return reached;
  }

  bool print_limits() const {
    bool reached = true;
    std::printf("\n| job | truepose | at most |\n|---|--:|--:|\n");
    for (const Limit& row : limits()) {
      const auto ours = nanoseconds_.find(row.ours);
      if (ours == nanoseconds_.end()) continue;
      reached = reached && ours->second <= row.limit_ns;
      std::printf("| %s | %s | %s |\n", row.job.c_str(), time(ours->second).c_str(),
                  time(row.limit_ns).c_str());
    }
    return reached;
  }

  static std::string time(double nanoseconds) {
    char text[32];
    if (nanoseconds < 1e3) {
      std::snprintf(text, sizeof text, "%.1f ns", nanoseconds);
    } else if (nanoseconds < 1e6) {
      std::snprintf(text, sizeof text, "%.2f us", nanoseconds * 1e-3);
    } else if (nanoseconds < 1e9) {
      std::snprintf(text, sizeof text, "%.2f ms", nanoseconds * 1e-6);
    } else {
      std::snprintf(text, sizeof text, "%.2f s", nanoseconds * 1e-9);
    }
    return text;
  }

  std::map<std::string, double> nanoseconds_;
  bool failed_ = false;
};

}  // namespace

/// Without arguments: the tables of medians of nine interleaved repetitions, exit status 1 where a goal is
/// missed; --isa=baseline|avx2|avx512 first measures the code of another instruction set than the
/// machine's best. With further arguments: Google Benchmark as they say.
int main(int argc, char** argv) {
  using truepose::kernels::Isa;
  const std::map<std::string, Isa> isas{
      {"--isa=baseline", Isa::Baseline}, {"--isa=avx2", Isa::Avx2}, {"--isa=avx512", Isa::Avx512}};
  std::vector<std::string> words(argv + 1, argv + argc);
  if (!words.empty() && isas.contains(words[0])) {
    const Isa isa = isas.at(words[0]);
    if (!truepose::kernels::available(isa)) {
      std::fprintf(stderr, "%s: this machine has no such instruction set\n", words[0].c_str());
      return 2;
    }
    truepose::kernels::use(isa);
    words.erase(words.begin());
  }
  const bool table = words.empty();
  words.insert(words.begin(), {argv[0], "--benchmark_enable_random_interleaving=true",
                               "--benchmark_repetitions=9", "--benchmark_min_time=0.05"});
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  int count = static_cast<int>(arguments.size());
  benchmark::Initialize(&count, arguments.data());
  if (benchmark::ReportUnrecognizedArguments(count, arguments.data())) return 2;
  if (!table) {
    benchmark::RunSpecifiedBenchmarks();
    return 0;
  }
  Medians medians;
  benchmark::RunSpecifiedBenchmarks(&medians);
  return medians.print() ? 0 : 1;
}
