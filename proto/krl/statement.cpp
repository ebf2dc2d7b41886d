#include "proto/krl/statement.hpp"

#include <limits>

namespace truepose::krl {
namespace {

int read_size(TokenReader& reader) {
  const Token& size = reader.take();
  const auto number = size.kind == TokenKind::Integer ? size.number() : std::nullopt;
  if (!number || *number < 1 || *number > std::numeric_limits<int>::max())
    reader.fail("the size of an array is a whole number from 1");
  return static_cast<int>(*number);
}

}  // namespace

Assignment read_assignment(TokenReader& reader) {
  Assignment assignment{.variable = read_variable(reader), .value = {}};
  reader.expect("=");
  assignment.value = read_expression(reader);
  return assignment;
}

std::vector<Assignment> read_settings(TokenReader& reader) {
  std::vector<Assignment> settings;
  if (!reader.take_if("WITH")) return settings;
  do settings.push_back(read_assignment(reader));
  while (reader.take_if(","));
  return settings;
}

bool is_motion(const Token& word) {
  return word.is_any_of({"PTP", "LIN", "CIRC", "PTP_REL", "LIN_REL", "CIRC_REL", "SPTP", "SLIN", "SCIRC",
                         "SPL", "SPTP_REL", "SLIN_REL", "SCIRC_REL", "SPL_REL"});
}

Motion read_motion(TokenReader& reader) {
  Motion motion{.word = reader.take().word()};
  while (motion.targets.size() < motion.target_count() && !reader.at_end()) {
    motion.targets.push_back(read_expression(reader));
    if (motion.targets.size() < motion.target_count() && !reader.take_if(",")) return motion;
  }
  if (motion.is_relative() && reader.peek().kind == TokenKind::Constant) {
    motion.frame = reader.take().word();
    if (motion.frame != "TOOL" && motion.frame != "BASE")
      reader.fail("#BASE or #TOOL is expected instead of #" + motion.frame);
  }
  if (motion.target_count() == 2 && reader.take_if(",")) {
    reader.expect("CA");
    motion.angle = read_expression(reader);
  }
  if (motion.is_spline()) motion.settings = read_settings(reader);
  return motion;
}

const Token* declared_type(Tokens statement) {
  std::size_t i = 0;
  while (i < statement.size() && statement[i].is_any_of({"DECL", "GLOBAL", "CONST"})) ++i;
  const bool is_one = i + 1 < statement.size() && statement[i].kind == TokenKind::Name &&
                      statement[i + 1].kind == TokenKind::Name;
  return is_one ? &statement[i] : nullptr;
}

void read_declaration(TokenReader& reader, Declaration& declaration) {
  for (; reader.peek().is_any_of({"DECL", "GLOBAL", "CONST"}); reader.take()) {
    declaration.is_global |= reader.next_is("GLOBAL");
    declaration.is_constant |= reader.next_is("CONST");
  }
  declaration.type = reader.peek();
  reader.take_name("a type");
  do {
    const Token& name = reader.peek();
    reader.take_name("a variable");
    Declaration::Name& declared = declaration.names.emplace_back(name);
    declared.sizes = read_sizes(reader);
    if (reader.take_if("=")) declared.value = read_expression(reader);
  } while (reader.take_if(","));
}

std::vector<int> read_sizes(TokenReader& reader) {
  std::vector<int> sizes;
  if (!reader.take_if("[")) return sizes;
  const bool is_open = reader.next_is("]") || reader.next_is(",");
  do sizes.push_back(is_open ? 0 : read_size(reader));
  while (reader.take_if(","));
  if (!is_open && sizes.size() > 3) reader.fail("an array has three dimensions at most");
  reader.expect("]");
  return sizes;
}

bool begins_routine(Tokens statement) {
  if (statement[0].is("GLOBAL")) statement = statement.subspan(1);
  return !statement.empty() && statement[0].is_any_of({"DEF", "DEFFCT"});
}

}  // namespace truepose::krl
