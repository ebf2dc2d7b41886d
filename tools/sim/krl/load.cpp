#include "tools/sim/krl/load.hpp"

#include <algorithm>
#include <utility>

#include "tools/sim/krl/body_compiler.hpp"
#include "tools/sim/krl/data_compiler.hpp"
#include "tools/sim/krl/memory.hpp"
#include "tools/sim/krl/standard.hpp"

namespace truepose::sim::krl {
namespace {

struct FileName {
  std::string module;
  std::string extension;
};

FileName split(const std::string& file) {
  const std::string name = in_capitals(file.substr(file.find_last_of("/\\") + 1));
  const std::size_t dot = std::min(name.find_last_of('.'), name.size());
  return {name.substr(0, dot), name.substr(dot)};
}

class Loader {
 public:
  explicit Loader(const Environment& environment) : environment_{environment} {}

  Program load(std::span<const Source> sources) {
    declare("the interpreter's declarations", standard_declarations());
    for (External& external : symbols_.program.externals)
      external.is_builtin = external.passes_advance_run = true;
    declare("the controller's declarations", environment_.declarations);
    symbols_.end_environment();
    for (const Source& source : sources)
      symbols_.attempt(source.is_partial, [&] { sort_in(source); }, {split(source.file).module});
    // What the whole controller knows comes first.
    std::ranges::stable_partition(lists_, &ModuleFile::is_global);
    for (const ModuleFile& list : lists_) collect_types(list, symbols_);
    std::vector<Body> bodies;
    for (const ModuleFile& file : programs_)
      std::ranges::move(scan_routines(file, symbols_), std::back_inserter(bodies));
    for (const ModuleFile& list : lists_) compile_data(list, symbols_, environment_.pass_advance_run);
    symbols_.program.code.push_back({Op::Done});
    for (const Body& body : bodies) BodyCompiler(body, symbols_).compile();
    Memory{symbols_.program};  // finds initial values that do not fit
    return std::move(symbols_.program);
  }

 private:
  void declare(const std::string& name, std::string_view text) {
    const ModuleFile list{.name = name,
                          .statements = statements_of(name, text),
                          .module = symbols_.module_of("$" + name),
                          .file = symbols_.add_file(name),
                          .is_environment = true,
                          .is_global = true};
    collect_types(list, symbols_);
    compile_data(list, symbols_, environment_.pass_advance_run);
  }

  void sort_in(const Source& source) {
    const FileName name = split(source.file);
    const bool is_program = name.extension == ".SRC" || name.extension == ".SUB";
    if (!is_program && name.extension != ".DAT")
      throw Fault{source.file, 0, "a file of KRL ends in .src, .sub or .dat"};
    (is_program ? programs_ : lists_)
        .push_back({.name = source.file,
                    .statements = statements_of(source.file, source.text),
                    .module = symbols_.module_of(name.module),
                    .file = symbols_.add_file(source.file),
                    .is_global = name.module.starts_with('$'),
                    .is_partial = source.is_partial});
  }

  const Environment& environment_;
  Symbols symbols_;
  std::vector<ModuleFile> lists_, programs_;
};

}  // namespace

std::expected<Program, Fault> load(const Environment& environment, std::span<const Source> sources) {
  try {
    return Loader(environment).load(sources);
  } catch (const Fault& fault) {
    return std::unexpected(fault);
  }
}

}  // namespace truepose::sim::krl
