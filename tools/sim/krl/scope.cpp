#include "tools/sim/krl/scope.hpp"

#include <algorithm>

namespace truepose::sim::krl {

std::size_t Scope::emit(Op op, std::size_t a, std::size_t b) {
  symbols.program.code.push_back(
      {op, static_cast<std::int32_t>(a), static_cast<std::int32_t>(b), line, file});
  return here() - 1;
}

void Scope::fetch(std::size_t before) {
  std::vector<Instruction>& code = symbols.program.code;
  if (code[before].op == Op::AdvanceStop) ++before;
  Instruction& place = code[before];
  const std::size_t length = code.size() - before;
  if (length == 1 && place.op == Op::Global) {
    place.op = Op::FetchGlobal;
  } else if (length == 1 && place.op == Op::Local) {
    place.op = Op::FetchLocal;
  } else if (length == 1 && place.op == Op::System) {
    place.op = Op::FetchSystem;
  } else if (const auto index =
                 constant_index({code.begin() + static_cast<std::ptrdiff_t>(before), code.end()})) {
    place = {Op::FetchSystem, place.a, *index, place.line, place.file};
    code.resize(before + 1);
  } else {
    emit(Op::Fetch);
  }
}

std::optional<std::int32_t> Scope::constant_index(std::span<const Instruction> place) const {
  const bool is_element =
      place.size() == 3 && place[0].op == Op::System && place[1].op == Op::Push && place[2].op == Op::Index;
  if (!is_element) return std::nullopt;
  const Program& program = symbols.program;
  const Variable& variable = program.systems[static_cast<std::size_t>(place[0].a)];
  const auto* const index =
      std::get_if<std::int32_t>(&program.constants[static_cast<std::size_t>(place[1].a)]);
  const bool is_in = index != nullptr && *index >= 1 && *index <= variable.type.sizes[0];
  return is_in ? std::optional{*index} : std::nullopt;
}

void Scope::stop_advance_run() {
  if (!is_continued && aside.empty() && !is_submit) emit(Op::AdvanceStop);
}

void Scope::push(Value constant) {
  symbols.program.constants.push_back(std::move(constant));
  emit(Op::Push, symbols.program.constants.size() - 1);
}

std::size_t Scope::add_hidden(Type type) {
  locals.push_back({"", std::move(type)});
  return locals.size() - 1;
}

Symbol Scope::variable(const std::string& name) const {
  const auto local = std::ranges::find(locals, name, &Field::name);
  if (local != locals.end()) {
    if (!aside.empty())
      fail("the " + std::string(aside) + " uses " + name +
           ", which is local data; it may use module data and $ variables");
    return {Storage::Local, static_cast<std::size_t>(local - locals.begin()), local->type, false, true};
  }
  const auto symbol = symbols.find_variable(name, module);
  if (!symbol) fail("the name " + name + " is not known" + symbols.why_unknown(name));
  return *symbol;
}

void Scope::refuse(std::size_t before, const Fault& fault) {
  symbols.program.code.resize(before);
  emit(Op::Refuse, symbols.program.refusals.size());
  symbols.refuse(fault);
}

void Scope::fail(const std::string& what) const {
  throw Fault{symbols.program.files[static_cast<std::size_t>(file)], line, what};
}

}  // namespace truepose::sim::krl
