#include "tools/sim/krl/scope.hpp"

#include <algorithm>

namespace truepose::sim::krl {

std::size_t Scope::emit(Op op, std::size_t a, std::size_t b) {
  symbols.program.code.push_back(
      {op, static_cast<std::int32_t>(a), static_cast<std::int32_t>(b), line, file});
  return here() - 1;
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
