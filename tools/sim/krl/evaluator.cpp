#include "tools/sim/krl/evaluator.hpp"

#include <algorithm>
#include <utility>

#include "tools/sim/krl/operations.hpp"

namespace truepose::sim::krl {
namespace {

[[noreturn]] void fail(std::string what) { throw Fault{.what = std::move(what)}; }

void check_index(std::int64_t index, std::size_t size) {
  if (index >= 0 && index < static_cast<std::int64_t>(size)) return;
  fail("the index " + std::to_string(index + 1) + " lies outside of an array of " + std::to_string(size));
}

using Path = std::span<const std::int64_t>;

Value part_of(const Value& whole, Path path) {
  if (path.empty()) return whole;
  const auto index = static_cast<std::size_t>(path[0]);
  if (const auto* text = std::get_if<std::string>(&whole)) {
    check_index(path[0], text->size());
    return (*text)[index] == '\0' ? Value{} : Value{(*text)[index]};
  }
  const auto* parts = std::get_if<Parts>(&whole);
  if (!parts) return {};
  check_index(path[0], parts->size());
  return part_of((*parts)[index], path.subspan(1));
}

void set_text(std::string& array, const std::string& text) {
  if (!fill(array, text))
    fail("the text has " + std::to_string(text.size()) + " characters and the array " +
         std::to_string(array.size()));
}

}  // namespace

void set_part(Value& whole, Path path, Value value) {
  auto* text = std::get_if<std::string>(&whole);
  if (path.empty()) {
    if (text) return set_text(*text, std::get<std::string>(value));
    whole = std::move(value);
    return;
  }
  const auto index = static_cast<std::size_t>(path[0]);
  if (text) {
    check_index(path[0], text->size());
    (*text)[index] = std::get<char>(value);
    return;
  }
  Parts& parts = std::get<Parts>(whole);
  check_index(path[0], parts.size());
  set_part(parts[index], path.subspan(1), std::move(value));
}

bool has_type(const Value& value, const Type& type, const Types& types) {
  if (std::holds_alternative<std::monostate>(value)) return true;
  if (type.is_text()) return std::holds_alternative<std::string>(value);
  const auto* parts = std::get_if<Parts>(&value);
  if (type.is_array()) {
    const bool fits = parts && (type.sizes[0] == 0 || static_cast<int>(parts->size()) == type.sizes[0]);
    return fits && std::ranges::all_of(*parts, [&, element = type.element()](const Value& part) {
             return has_type(part, element, types);
           });
  }
  switch (type.kind) {
    case Kind::Int:
      return std::holds_alternative<std::int32_t>(value);
    case Kind::Real:
      return std::holds_alternative<double>(value);
    case Kind::Bool:
      return std::holds_alternative<bool>(value);
    case Kind::Char:
      return std::holds_alternative<char>(value);
    case Kind::Enumeration: {
      const auto* literal = std::get_if<Literal>(&value);
      return literal && types.enumeration(type).has(literal->name);
    }
    case Kind::Structure:
      return parts && std::ranges::equal(*parts, types.structure(type).fields,
                                         [&](const Value& part, const Field& field) {
                                           return has_type(part, field.type, types);
                                         });
    default:
      return false;
  }
}

Value Evaluator::pop() {
  Value value = std::get<Value>(std::move(operands.back()));
  operands.pop_back();
  return value;
}

Place Evaluator::pop_place() {
  Place place = std::get<Place>(std::move(operands.back()));
  operands.pop_back();
  return place;
}

void Evaluator::execute(const Instruction& instruction) {
  if (!execute_place(instruction)) operate(instruction, program_, *this);
}

void Evaluator::execute_all(std::size_t at) {
  for (; program_.code[at].op != Op::Done; ++at) {
    try {
      execute(program_.code[at]);
    } catch (Fault& fault) {
      fault.file = program_.files[static_cast<std::size_t>(program_.code[at].file)];
      fault.line = program_.code[at].line;
      throw;
    }
  }
}

bool Evaluator::execute_place(const Instruction& instruction) {
  const auto a = static_cast<std::size_t>(instruction.a);
  switch (instruction.op) {
    case Op::Push:
      push(program_.constants[a]);
      return true;
    case Op::Global:
      operands.emplace_back(Place{Storage::Global, a});
      return true;
    case Op::Local: {
      const auto* referred = std::get_if<Place>(&locals.back().values[a]);
      operands.emplace_back(referred ? *referred : Place{Storage::Local, a, locals.size() - 1});
      return true;
    }
    case Op::System:
      operands.emplace_back(Place{Storage::System, a});
      return true;
    case Op::Index: {
      const std::int64_t index = pop_int();
      std::get<Place>(operands.back()).path.push_back(index - 1);
      return true;
    }
    case Op::Bits: {
      Place& place = std::get<Place>(operands.back());
      place.path.push_back(instruction.a);
      place.bits = instruction.b;
      return true;
    }
    case Op::Field:
      std::get<Place>(operands.back()).path.push_back(instruction.a);
      return true;
    case Op::Fetch:
      push(fetch(pop_place()));
      return true;
    case Op::FetchGlobal:
      push_set(globals_[a], {Storage::Global, a});
      return true;
    case Op::FetchLocal: {
      const Operand& local = locals.back().values[a];
      if (const auto* const value = std::get_if<Value>(&local))
        push_set(*value, {Storage::Local, a, locals.size() - 1});
      else
        push(fetch(std::get<Place>(local)));
      return true;
    }
    case Op::FetchSystem: {
      const Variable& variable = program_.systems[a];
      Place place{Storage::System, a};
      const auto index = instruction.b != 0 ? std::optional{int{instruction.b}} : std::nullopt;
      if (index) place.path.push_back(*index - 1);
      push_set(asked_for(variable, index, index ? variable.element : variable.type, place), place);
      return true;
    }
    case Op::Store: {
      Value value = pop();
      store(pop_place(), std::move(value));
      return true;
    }
    case Op::VariableState:
      push(Literal{is_set(look(pop_place())) ? "INITIALIZED" : "DECLARED"});
      return true;
    case Op::Gather:
      gather(instruction);
      return true;
    case Op::Drop:
      operands.pop_back();
      return true;
    default:
      return false;
  }
}

void Evaluator::gather(const Instruction& instruction) {
  Value whole = program_.types.blank({Kind::Structure, instruction.a});
  const std::vector<int>& shape = program_.shapes[static_cast<std::size_t>(instruction.b)];
  for (std::size_t i = shape.size(); i-- > 0;) {
    const std::int64_t field = shape[i];
    set_part(whole, {&field, 1}, pop());
  }
  push(std::move(whole));
}

Value Evaluator::look(const Place& place) {
  if (place.storage == Storage::System) return look_at_system(place);
  const Value& root = place.storage == Storage::Global
                          ? globals_[place.slot]
                          : std::get<Value>(locals[place.frame].values[place.slot]);
  return part_of(root, place.path);
}

Value Evaluator::fetch(const Place& place) {
  Value value = look(place);
  check_set(value, place);
  return value;
}

void Evaluator::push_set(const Value& value, const Place& place) {
  check_set(value, place);
  push(value);
}

void Evaluator::check_set(const Value& value, const Place& place) const {
  // A text without characters is a text.
  if (!is_set(value) && !std::holds_alternative<std::string>(value))
    throw Fault{.what = "the variable " + describe(place) + " has no value", .number = kNoValueError};
}

void Evaluator::store(const Place& place, Value value) {
  if (place.storage == Storage::System) return store_in_system(place, std::move(value));
  Value& root = place.storage == Storage::Global ? globals_[place.slot]
                                                 : std::get<Value>(locals[place.frame].values[place.slot]);
  set_part(root, place.path, std::move(value));
}

Value Evaluator::look_at_bits(const Place& place) {
  Place bit{.storage = place.storage, .slot = place.slot, .path = place.path};
  std::uint32_t number = 0;
  for (std::int32_t i = 0; i < place.bits; ++i, ++bit.path[0]) {
    const Value value = look_at_system(bit);
    if (!is_set(value)) return {};
    number |= static_cast<std::uint32_t>(std::get<bool>(value)) << i;
  }
  return static_cast<std::int32_t>(number);
}

void Evaluator::store_bits(const Place& place, std::uint32_t number) {
  constexpr int kWord = 32;
  if (place.bits < kWord && number >> place.bits != 0)
    fail("the number has more than the " + std::to_string(place.bits) + " bits of " + describe(place));
  Place bit{.storage = place.storage, .slot = place.slot, .path = place.path};
  for (std::int32_t i = 0; i < place.bits; ++i, ++bit.path[0]) store_in_system(bit, (number >> i & 1) != 0);
}

Evaluator::Asked Evaluator::asked_of_host(const Place& place) const {
  const Variable& variable = program_.systems[place.slot];
  if (!variable.type.is_array() || place.path.empty())
    return {variable, std::nullopt, variable.type, place.path};
  const std::int64_t index = place.path[0];
  check_index(index, static_cast<std::size_t>(variable.type.sizes[0]));
  return {variable, static_cast<int>(index) + 1, variable.element, Path(place.path).subspan(1)};
}

Value Evaluator::look_at_system(const Place& place) {
  if (place.bits > 0) return look_at_bits(place);
  const auto [variable, index, type, path] = asked_of_host(place);
  return part_of(asked_for(variable, index, type, place), path);
}

Value Evaluator::asked_for(const Variable& variable, std::optional<int> index, const Type& type,
                           const Place& place) {
  Value value = host_->read(variable, index);
  if (!has_type(value, type, program_.types))
    fail("the controller has no value of type " + program_.types.name(type) + " for " + describe(place));
  return value;
}

void Evaluator::store_in_system(const Place& place, Value value) {
  if (place.bits > 0) return store_bits(place, static_cast<std::uint32_t>(std::get<std::int32_t>(value)));
  const auto [variable, index, type, path] = asked_of_host(place);
  if (!path.empty()) {
    Value whole = host_->read(variable, index);
    if (std::holds_alternative<std::monostate>(whole)) whole = program_.types.blank(type);
    set_part(whole, path, std::move(value));
    value = std::move(whole);
  }
  if (const auto written = host_->write(variable.name, index, value); !written)
    fail(describe(place) + ": " + written.error());
}

Field Evaluator::root_of(const Place& place) const {
  if (place.storage == Storage::Local) return locals[place.frame].routine->local_names[place.slot];
  const Variable& variable =
      place.storage == Storage::Global ? program_.globals[place.slot] : program_.systems[place.slot];
  return {variable.name, variable.type};
}

std::string Evaluator::describe(const Place& place) const {
  auto [text, type] = root_of(place);
  for (const std::int64_t step : place.path) {
    if (type.is_array()) {
      // X[1,2]
      const bool goes_on = text.back() == ']';
      if (goes_on) text.pop_back();
      text += (goes_on ? "," : "[") + std::to_string(step + 1) + "]";
      type = type.element();
    } else {
      const Field& field = program_.types.structure(type).fields[static_cast<std::size_t>(step)];
      text += "." + field.name;
      type = field.type;
    }
  }
  return text;
}

}  // namespace truepose::sim::krl
