#include "tests/tools/sim/krl/bench.hpp"

#include <algorithm>
#include <stdexcept>

#include "tools/sim/krl/controller_declarations.hpp"

namespace truepose::sim::krl {
namespace {

std::string key(std::string_view name, std::optional<int> index) {
  return std::string(name) + (index ? "[" + std::to_string(*index) + "]" : "");
}

/// Of $config.dat and bas.src, for which the test answers.
const std::string kBasis = R"krl(
ENUM BAS_COMMAND INITMOV,ACC_CP,ACC_PTP,VEL_CP,VEL_PTP,TOOL,BASE,PTP_PARAMS,CP_PARAMS
EXT BAS(BAS_COMMAND:IN,REAL:IN)
EXT IR_STOPM()
)krl";

Program loaded(const std::vector<Source>& sources, const std::string& declarations,
               std::vector<std::string> pass_advance_run) {
  Environment environment = cell(declarations);
  environment.pass_advance_run = std::move(pass_advance_run);
  auto program = load(environment, sources);
  if (!program) throw std::runtime_error(program.error().text());
  return std::move(*program);
}

}  // namespace

Environment cell(const std::string& declarations) {
  return {.declarations = std::string{controller_declarations()} + kBasis + declarations};
}

Value FakeHost::read(const Variable& variable, std::optional<int> index) {
  const std::string_view name = variable.name;
  if (name == "$TIMER") return static_cast<int>((now - timer_zero_[*index]) / 1ms);
  if (const auto at = rewritten.find(key(name, index)); at != rewritten.end()) return at->second(now);
  if (const auto at = variables.find(key(name, index)); at != variables.end()) return at->second;
  const bool is_bit = name == "$FLAG" || name == "$IN" || name == "$OUT";
  return is_bit ? Value{false} : Value{};
}

std::expected<void, std::string> FakeHost::write(std::string_view name, std::optional<int> index,
                                                 const Value& value) {
  if (name == "$IN") return std::unexpected("an input cannot be written");
  if (name == "$TIMER") timer_zero_[*index] = now - std::get<std::int32_t>(value) * 1ms;
  variables[key(name, index)] = value;
  return {};
}

std::expected<CallResult, std::string> FakeHost::call(ExternalCall& call) {
  if (!on_call) return std::unexpected("nobody answers");
  return on_call(call);
}

std::expected<void, std::string> FakeHost::move(const Motion& motion) {
  log.push_back("move " + std::to_string(motion.number));
  moved.push_back(motion);
  making_.push_back({motion, motion_time});
  plan_switches(motion);
  return {};
}

void FakeHost::plan_switches(const Motion& motion) {
  Time arrives = now;
  for (const Making& making : making_) arrives += making.left;
  const auto plan = [&](const std::vector<SwitchingPoint>& points, Time begins, Time ends) {
    for (const SwitchingPoint& point : points) {
      const std::chrono::duration<double> shifted = motion_time * point.path_mm / 1000;
      const std::chrono::duration<double> delay{point.delay_s};
      switches_[point.number] =
          (point.from_start ? begins : ends) + std::chrono::round<Time>(shifted + delay);
    }
  };
  plan(motion.switching, arrives - motion_time, arrives);
  const auto count = static_cast<int>(motion.segments.size());
  for (int i = 0; i < count; ++i) {
    const Time begins = arrives - motion_time + motion_time * i / count;
    plan(motion.segments[static_cast<std::size_t>(i)].switching, begins, begins + motion_time / count);
  }
}

std::vector<std::uint64_t> FakeHost::take_switched() {
  std::vector<std::uint64_t> switched;
  std::erase_if(switches_, [&](const auto& point) {
    if (point.second > now) return false;
    switched.push_back(point.first);
    return true;
  });
  return switched;
}

bool FakeHost::is_finished(std::uint64_t motion) {
  return std::ranges::none_of(making_, [&](const Making& making) { return making.motion.number == motion; });
}

bool FakeHost::is_standing() { return making_.empty() || (braked_ && now >= *braked_ + braking_time); }

void FakeHost::brake(bool with_all_force) {
  log.push_back(with_all_force ? "brake hard" : "brake");
  braked_ = now;
}

void FakeHost::go_on() {
  log.push_back("go on");
  braked_.reset();
}

void FakeHost::cancel() {
  log.push_back("cancel");
  making_.clear();
  switches_.clear();
  braked_.reset();
}

void FakeHost::advance(Time to) {
  while (!braked_ && !making_.empty() && now + making_.front().left <= to) {
    now += making_.front().left;
    log.push_back(std::to_string(making_.front().motion.number) + " is made");
    if (on_arrival) on_arrival(making_.front().motion);
    making_.pop_front();
  }
  if (!braked_ && !making_.empty()) making_.front().left -= to - now;
  now = to;
}

std::optional<Time> FakeHost::next_change() const {
  if (braked_ && now < *braked_ + braking_time) return *braked_ + braking_time;
  std::optional<Time> next;
  for (const auto& [number, time] : switches_) {
    if (time > now) next = std::min(next.value_or(time), time);
  }
  if (braked_ || making_.empty()) return next;
  return std::min(next.value_or(Time::max()), now + making_.front().left);
}

Bench::Bench(std::vector<Source> sources, const std::string& declarations,
             std::vector<std::string> pass_advance_run)
    : program{loaded(sources, declarations, std::move(pass_advance_run))}, memory{program} {}

Interpreter& Bench::start(const std::string& name, InterpreterKind kind) {
  Interpreter& interpreter = interpreters.emplace_back(program, memory, host, kind);
  if (const auto selected = interpreter.select(name); !selected) throw std::runtime_error(selected.error());
  interpreter.start();
  interpreter.run(host.now);
  return interpreter;
}

void Bench::run_for(Time time) {
  const Time end = host.now + time;
  while (true) {
    for (Interpreter& interpreter : interpreters) interpreter.run(host.now);
    Time next = host.next_change().value_or(end);
    for (Interpreter& interpreter : interpreters)
      next = std::min(next, interpreter.next_change().value_or(end));
    if (next >= end) break;
    host.advance(next);
  }
  host.advance(end);
  for (Interpreter& interpreter : interpreters) interpreter.run(host.now);
}

Value Bench::variable(const std::string& name) const {
  const auto at = std::ranges::find(program.globals, name, &Variable::name);
  if (at == program.globals.end()) throw std::runtime_error("no variable " + name);
  return memory.globals[static_cast<std::size_t>(at - program.globals.begin())];
}

std::vector<Source> program_of(const std::string& statements, const std::string& data,
                               const std::string& more) {
  return {{"p.dat", "DEFDAT P PUBLIC\n" + data + "\nENDDAT\n"},
          {"p.src", "DEF P()\n" + statements + "\nEND\n" + more}};
}

std::string load_error(const std::vector<Source>& sources, const std::string& declarations) {
  const auto program = load(cell(declarations), sources);
  return program ? "" : program.error().text();
}

}  // namespace truepose::sim::krl
