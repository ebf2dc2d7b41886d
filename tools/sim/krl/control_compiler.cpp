// The part of BodyCompiler that branches, loops and returns.
#include <algorithm>
#include <ranges>
#include <utility>

#include "tools/sim/krl/body_compiler.hpp"

namespace truepose::sim::krl {

void BodyCompiler::condition(TokenReader& reader, const std::string& what) {
  expressions_.value_as(read_expression(reader), {Kind::Bool}, what);
}

void BodyCompiler::compile_if(TokenReader& reader) {
  const Statement& opened = body_.statements[at_ - 1];
  reader.take();
  attempt([&] {
    condition(reader, "the condition of IF");
    reader.expect("THEN");
    reader.expect_end();
  });
  const std::size_t unless = scope_.emit(Op::JumpUnless);
  if (block({"ELSE", "ENDIF"}, opened) == "ELSE") {
    close("ELSE");
    const std::size_t over = scope_.emit(Op::Jump);
    scope_.land(unless);
    block({"ENDIF"}, opened);
    scope_.land(over);
  } else {
    scope_.land(unless);
  }
  close("ENDIF");
}

void BodyCompiler::compile_switch(TokenReader& reader) {
  const Statement& opened = body_.statements[at_ - 1];
  reader.take();
  const std::size_t subject = scope_.add_hidden({});
  Type type;
  attempt([&] {
    scope_.emit(Op::Local, subject);
    type = expressions_.value(read_expression(reader));
    reader.expect_end();
    const bool fits = type.is(Kind::Int) || type.is(Kind::Char) || type.is(Kind::Enumeration);
    if (!fits) scope_.fail("SWITCH takes INT, CHAR or an enumeration, not " + scope_.types().name(type));
    scope_.emit(Op::Store);
  });
  if (!next_begins_with("CASE"))
    throw Fault{body_.file->name, at_end() ? opened[0].line : body_.statements[at_][0].line,
                "CASE is expected"};
  std::vector<std::size_t> exits;
  while (next_begins_with("CASE")) compile_case(subject, type, exits);
  if (next_begins_with("DEFAULT")) {
    close("DEFAULT");
    block({"ENDSWITCH"}, opened);
  }
  if (!next_begins_with("ENDSWITCH")) throw Fault{body_.file->name, opened[0].line, "ENDSWITCH is missing"};
  close("ENDSWITCH");
  for (const std::size_t exit : exits) scope_.land(exit);
}

void BodyCompiler::compile_case(std::size_t subject, const Type& type, std::vector<std::size_t>& exits) {
  const Statement& opened = body_.statements[at_++];
  scope_.line = opened[0].line;
  StatementReader reader(body_.file->name, opened);
  reader.expect("CASE");
  std::vector<std::size_t> matches;
  attempt([&] {
    if (type.kind == Kind::None) return;  // SWITCH itself is not known
    do {
      scope_.emit(Op::Local, subject);
      scope_.emit(Op::Fetch);
      expressions_.value_as(read_expression(reader), type, "the value of CASE");
      scope_.emit(Op::Unequal);
      matches.push_back(scope_.emit(Op::JumpUnless));
    } while (reader.take_if(","));
    reader.expect_end();
  });
  const std::size_t next = scope_.emit(Op::Jump);
  for (const std::size_t match : matches) scope_.land(match);
  block({"CASE", "DEFAULT", "ENDSWITCH"}, opened);
  exits.push_back(scope_.emit(Op::Jump));
  scope_.land(next);
}

/// @param lead_back  behind the last statement; it reads what ends the loop
void BodyCompiler::loop(std::string_view end, const std::function<void()>& lead_back) {
  exits_.emplace_back();
  block({end}, body_.statements[at_ - 1]);
  lead_back();
  for (const std::size_t exit : exits_.back()) scope_.land(exit);
  exits_.pop_back();
}

void BodyCompiler::compile_loop(TokenReader& reader) {
  reader.take();
  reader.expect_end();
  loop("ENDLOOP", [this, start = scope_.here()] {
    close("ENDLOOP");
    scope_.emit(Op::Jump, start);
  });
}

void BodyCompiler::compile_while(TokenReader& reader) {
  reader.take();
  const std::size_t start = scope_.here();
  attempt([&] {
    condition(reader, "the condition of WHILE");
    reader.expect_end();
  });
  const std::size_t unless = scope_.emit(Op::JumpUnless);
  loop("ENDWHILE", [&] {
    close("ENDWHILE");
    scope_.emit(Op::Jump, start);
    scope_.land(unless);
  });
}

void BodyCompiler::compile_repeat(TokenReader& reader) {
  reader.take();
  reader.expect_end();
  loop("UNTIL", [this, start = scope_.here()] {
    StatementReader end(body_.file->name, body_.statements[at_++]);
    end.take();
    attempt([&] {
      condition(end, "the condition of UNTIL");
      end.expect_end();
    });
    scope_.emit(Op::JumpUnless, start);
  });
}

/// Gives the counter its first value, and keeps the last and the step.
void BodyCompiler::for_range(TokenReader& reader, const Expression& counter, std::size_t last,
                             std::size_t step) {
  reader.expect("=");
  expressions_.assign(counter, read_expression(reader));
  reader.expect("TO");
  scope_.emit(Op::Local, last);
  expressions_.value_as(read_expression(reader), {Kind::Int}, "the end of FOR");
  scope_.emit(Op::Store);
  scope_.emit(Op::Local, step);
  if (reader.take_if("STEP")) {
    expressions_.value_as(read_expression(reader), {Kind::Int}, "the step of FOR");
  } else {
    scope_.push(1);
  }
  scope_.emit(Op::Store);
  reader.expect_end();
}

void BodyCompiler::compile_for(TokenReader& reader) {
  reader.take();
  const std::size_t last = scope_.add_hidden({Kind::Int}), step = scope_.add_hidden({Kind::Int});
  Expression counter;
  bool is_known = false;
  std::size_t start = scope_.here();
  attempt([&] {
    counter = read_variable(reader);
    for_range(reader, counter, last, step);
    start = scope_.here();
    if (!expressions_.value(counter).is(Kind::Int)) scope_.fail("the counter of FOR is INT");
    is_known = true;
  });
  scope_.emit(Op::ForGoesOn, last);
  const std::size_t unless = scope_.emit(Op::JumpUnless);
  loop("ENDFOR", [&] {
    if (is_known) {
      expressions_.place(counter);
      expressions_.value(counter);
      scope_.emit(Op::Local, step);
      scope_.emit(Op::Fetch);
      scope_.emit(Op::Add);
      scope_.emit(Op::Store);
    }
    close("ENDFOR");
    scope_.emit(Op::Jump, start);
    scope_.land(unless);
  });
}

void BodyCompiler::compile_exit(TokenReader& reader) {
  reader.take();
  reader.expect_end();
  if (exits_.empty()) reader.fail("EXIT stands in no loop");
  exits_.back().push_back(scope_.emit(Op::Jump));
}

void BodyCompiler::compile_goto(TokenReader& reader) {
  reader.take();
  const std::string label = reader.take_name("a label");
  reader.expect_end();
  gotos_.push_back({scope_.emit(Op::Jump), label, blocks_, scope_.line});
}

void BodyCompiler::compile_label(TokenReader& reader) {
  const std::string label = reader.take_name("a label");
  reader.expect(":");
  reader.expect_end();
  if (!labels_.emplace(label, Label{scope_.here(), blocks_}).second)
    reader.fail("the label " + label + " stands twice");
}

void BodyCompiler::land_gotos() {
  for (const Goto& jump : gotos_) {
    const auto label = labels_.find(jump.label);
    if (label == labels_.end())
      throw Fault{body_.file->name, jump.line, "the label " + jump.label + " is not known"};
    const std::vector<int>& around = label->second.blocks;
    if (!std::ranges::equal(around, jump.blocks | std::views::take(around.size())))
      throw Fault{body_.file->name, jump.line, "GOTO leads into a loop or branch"};
    symbols_.program.code[jump.jump].a = static_cast<std::int32_t>(label->second.at);
  }
}

void BodyCompiler::compile_return(TokenReader& reader) {
  reader.take();
  const Type result = symbols_.program.routines[body_.routine].result;
  if (result.kind == Kind::None) {
    reader.expect_end();
    scope_.emit(Op::Return);
    return;
  }
  if (reader.at_end()) reader.fail("RETURN of a function needs a value");
  expressions_.value_as(read_expression(reader), result, "the result");
  reader.expect_end();
  scope_.emit(Op::Return, 0, 1);
}

/// HALT, RESUME and ON_ERROR_PROCEED, which stand alone in their line.
void BodyCompiler::compile_plain(TokenReader& reader) {
  const Token& word = reader.take();
  reader.expect_end();
  if (word.is("HALT")) scope_.stop_advance_run();
  scope_.emit(word.is("HALT") ? Op::Halt : word.is("RESUME") ? Op::Resume : Op::Proceed);
}

void BodyCompiler::compile_continue(TokenReader& reader) {
  reader.take();
  reader.expect_end();
  continued_ = true;
}

void BodyCompiler::compile_assignment(TokenReader& reader) {
  if (reader.next_is("$CYCFLAG")) return compile_cyclical(reader);
  const Assignment assignment = read_assignment(reader);
  reader.expect_end();
  expressions_.assign(assignment.variable, assignment.value);
}

}  // namespace truepose::sim::krl
