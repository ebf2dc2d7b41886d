#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "tools/sim/krl/program.hpp"
#include "tools/sim/krl/statement_reader.hpp"

namespace truepose::sim::krl {

enum class Storage { Local, Global, System };

/// A file of a module, or the declarations of the environment, which are a data list.
struct ModuleFile {
  std::string name;  ///< for messages
  std::vector<Statement> statements;
  int module = 0;
  int file = 0;
  bool is_environment = false;  ///< without DEFDAT and ENDDAT; all of it is known to all, and EXT declares
  bool is_global = false;       ///< all of its data is known to all modules
  bool is_partial = false;      ///< as Source::is_partial
};

/// What a name of a variable stands for.
struct Symbol {
  Storage storage = Storage::Local;
  std::size_t slot = 0;
  Type type;
  bool is_constant = false;
  bool passes_advance_run = false;
  std::optional<std::int32_t> element = {};  ///< of SIGNAL: which element of the system variable
  std::int32_t bits = 0;  ///< of SIGNAL ... TO: from there so many, the lowest first, as INT
};

/// SIGNAL: another name for an element of a system variable, or a number of them.
struct Signal {
  std::string name;
  int module = 0;
  bool is_global = false;
  Symbol symbol;
};

/// The program that is being compiled, and its names.
class Symbols {
 public:
  Program program;

  /// @param name  of a file without its extension, in capitals
  int module_of(const std::string& name);
  /// What was added so far is the environment's.
  void end_environment() { environment_globals_ = program.globals.size(); }
  bool is_environments(const Symbol& symbol) const {
    return symbol.storage == Storage::Global && symbol.slot < environment_globals_;
  }
  const std::string& module_name(int module) const { return modules_[static_cast<std::size_t>(module)]; }
  int add_file(const std::string& file);

  std::optional<Symbol> find_variable(std::string_view name, int module) const;
  std::optional<std::size_t> find_routine(std::string_view name, int module) const;
  std::optional<std::size_t> find_external(std::string_view name) const;

  /// Adds a module variable. Errors: the name is taken.
  Symbol add_variable(const Variable& variable, const TokenReader& reader);
  /// Adds a variable for which the host answers. Errors: the name is taken.
  Symbol add_system(const Variable& variable, const TokenReader& reader);
  void add_routine(Routine routine);
  /// Errors: the name is taken.
  void add_signal(Signal signal, const TokenReader& reader);
  void add_external(External external);

  /// Fails where a variable, parameter or subprogram must not be called so.
  void check_new_name(const std::string& name, const TokenReader& reader) const;

  /// Notes what is not known of a partial source. @param names  what it would have declared, in capitals
  void refuse(const Fault& fault, const std::vector<std::string>& names = {});
  /// Does what may find a fault, which is noted of a partial source and else continues to the caller.
  /// @param names  as of refuse(). @return whether none was found
  template <typename Part>
  bool attempt(bool is_partial, Part part, const std::vector<std::string>& names = {}) {
    try {
      part();
      return true;
    } catch (const Fault& fault) {
      if (!is_partial) throw;
      refuse(fault, names);
      return false;
    }
  }
  /// Why a name is not known: " (sps.sub:12: ...)"; empty where no partial source would have declared it.
  std::string why_unknown(const std::string& name) const;

 private:
  using Slots = std::unordered_map<std::string, std::vector<std::size_t>>;

  std::vector<std::string> modules_;
  std::vector<Signal> signals_;
  std::size_t environment_globals_ = 0;
  Slots systems_, globals_, signals_of_, routines_, externals_;  // by name
  std::unordered_map<std::string, Fault> refused_;               // by name
};

/// Whether a declaration begins here: DECL, GLOBAL INT, INT X, E6POS P. `GLOBAL DEF` and `GLOBAL INTERRUPT`
/// are none.
bool begins_declaration(const TokenReader& reader, const Types& types);

/// Reads :IN or :OUT; OUT where nothing stands.
Direction read_direction(TokenReader& reader);

/// The type that a name says. Errors: it is not known.
Type type_of(const Token& name, const TokenReader& reader, const Types& types);

/// The array of it. Errors: the variable is too large.
Type sized(Type type, std::vector<int> sizes, const TokenReader& reader, const Types& types);

}  // namespace truepose::sim::krl
