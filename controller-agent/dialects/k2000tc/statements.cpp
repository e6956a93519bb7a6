// Macro statements: assignments, jumps, loops, messages, calls (L19545-L20690).
#include "dialects/k2000tc/language.hpp"

namespace headstock::dialects::k2000tc {
namespace {

using k2000::Error;
using k2000::Operator;
using k2000::Place;

constexpr std::int64_t kMostLabel = 1'023;
constexpr std::size_t kMostArguments = 32;
constexpr std::size_t kMostText = 512;

struct Compound {
  std::string_view text;
  Operator op;
};
constexpr Compound kCompounds[] = {
    {"<<=", Operator::shift_left}, {">>=", Operator::shift_right}, {"+=", Operator::add},
    {"-=", Operator::subtract},    {"*=", Operator::multiply},     {"/=", Operator::divide},
    {"&=", Operator::bit_and},     {"^=", Operator::bit_xor},      {"|=", Operator::bit_or}};

}  // namespace

bool Language::raise(Executor& ex, std::string_view code, std::uint32_t column, std::string detail) {
  return ex.alarm_code(code, column, std::move(detail));
}

bool Language::wrong_value(Executor& ex, Error error, std::uint32_t column) {
  switch (error) {
    case Error::null_used:
      return raise(ex, "PS9005", column, "NULL");
    case Error::undefined:
    case Error::no_variable:
      return raise(ex, "PS1318", column, {});
    case Error::none:
    case Error::syntax:
      return ex.alarm(AlarmReason::expression, column);
    default:
      return raise(ex, "PS9006", column, {});
  }
}

// The alarm of the parser's mistake.
bool Language::wrong(Statement& s, Error otherwise) {
  return wrong_value(s.ex, s.parser.error() == Error::none ? otherwise : s.parser.error(), s.here());
}

interp::OwnLanguage::Taken Language::statement(Executor& ex, std::string_view text, std::uint32_t column) {
  Statement s{ex, k2000::Parser(text, *this, options_), column};
  if (run_statement(s) && !ex.finished && !s.parser.at_end()) wrong(s);
  if (!ex.finished && ex.data.bit("P4100.7")) {  // SBKM: single block stops here too (L19776)
    auto& passed = ex.emit<interp::Message>();
    passed.at = ex.at;
    passed.kind = interp::MessageKind::statement;
  }
  return Taken::done;
}

bool Language::run_statement(Statement& s) {
  struct Keyword {
    std::string_view text;
    bool (*run)(Language&, Statement&);
  };
  static constexpr Keyword kKeywords[] = {
      {"IF", [](Language& l, Statement& st) { return l.do_if(st); }},
      {"GOTO", [](Language& l, Statement& st) { return l.do_goto(st); }},
      {"WHILE", [](Language& l, Statement& st) { return l.do_loop(st, true); }},
      {"DO", [](Language& l, Statement& st) { return l.do_loop(st, false); }},
      {"END", [](Language& l, Statement& st) { return l.do_end(st); }},
      {"MSG", [](Language& l, Statement& st) { return l.do_message(st); }},
      {"ERR", [](Language& l, Statement& st) { return l.do_error(st); }},
      {"WRITE", [](Language& l, Statement& st) { return l.do_write(st); }},
      {"OPENWRITE", [](Language& l, Statement& st) { return l.do_handle(st, true); }},
      {"CLOSEWRITE", [](Language& l, Statement& st) { return l.do_handle(st, false); }},
      {"CALL", [](Language& l, Statement& st) { return l.do_call(st); }},
      {"PARAMS", [](Language& l, Statement& st) { return l.do_params(st); }},
  };
  if (s.parser.is_place()) return assignment(s);
  for (const Keyword& keyword : kKeywords) {
    if (s.parser.take(keyword.text)) return keyword.run(*this, s);
  }
  return wrong(s);
}

bool Language::assign_array(Statement& s, const Place& target) {
  Operator op{};
  bool compound = false;
  for (const Compound& written : kCompounds) {
    if (!s.parser.take(written.text)) continue;
    op = written.op;
    compound = true;
    break;
  }
  if (!compound && !s.parser.take('=')) return wrong(s);
  Place source;
  if (!s.parser.place(source)) return wrong(s);
  if (source.count != target.count) return wrong(s, Error::array_size);
  for (std::uint32_t i = 0; i < target.count; ++i) {
    Value value, old;
    Error error = read(source.number + i, value);
    if (error == Error::none && compound) {
      error = read(target.number + i, old);
      if (error == Error::none) error = apply(op, old, value, value);
    }
    if (error == Error::none) error = write(target.number + i, value);
    if (error != Error::none) return wrong(s, error);
  }
  return true;
}

bool Language::assignment(Statement& s) {
  Place target;
  if (!s.parser.place(target)) return wrong(s);
  if (target.count != 0) return assign_array(s, target);
  for (const Compound& written : kCompounds) {
    if (!s.parser.take(written.text)) continue;
    Value right, old;
    if (!s.parser.expression(right)) return wrong(s);
    Error error = read(target.number, old);
    if (error == Error::none && old.is_null()) error = Error::undefined;
    if (error == Error::none) error = apply(written.op, old, right, right);
    if (error == Error::none) error = write(target.number, right);
    return error == Error::none || wrong(s, error);
  }
  if (!s.parser.take('=')) return wrong(s);
  Value value;
  if (!s.parser.value_or_null(value)) return wrong(s);
  const Error error = write(target.number, value);
  return error == Error::none || wrong(s, error);
}

bool Language::whole(Statement& s, std::int64_t& value) {
  Value given;
  if (!s.parser.expression(given)) return wrong(s);
  if (given.is_null()) return wrong(s, Error::null_used);
  const auto integer = given.integer();
  if (!integer) return wrong(s, Error::whole_needed);
  value = *integer;
  return true;
}

// A condition's value must be a whole number (L19882).
bool Language::condition(Statement& s, bool& yes) {
  Value value;
  if (!s.parser.bracket(value)) return wrong(s);
  if (value.is_null()) return wrong(s, Error::null_used);
  if (!value.is_whole()) return wrong(s, Error::whole_needed);
  yes = value.truth();
  return true;
}

bool Language::do_if(Statement& s) {
  bool yes = false;
  if (!condition(s, yes)) return false;
  if (s.parser.take("GOTO")) {
    if (yes) return do_goto(s);
    std::int64_t target = 0;
    return whole(s, target);
  }
  if (!s.parser.take("THEN")) return wrong(s);
  if (yes) return assignment(s);
  s.parser.skip_rest();  // not carried out, so not read
  return true;
}

bool Language::jump(Executor& ex, std::int64_t target, std::uint32_t column) {
  for (Loop& loop : level(ex).loops) loop.left_by_jump = true;
  return ex.jump_to_sequence(target < 0 ? -target : target, column);
}

// GOTO n, GOTO[-n]: a negative number only says where the search begins (L19800).
bool Language::do_goto(Statement& s) {
  const std::uint32_t column = s.here();
  std::int64_t target = 0;
  if (!whole(s, target)) return false;
  if (!s.parser.at_end()) return wrong(s);
  if (target == 0 || target > 99'999 || target < -99'999)
    return s.ex.alarm(AlarmReason::sequence_not_found, column, "N" + std::to_string(target));
  return jump(s.ex, target, column);
}

bool Language::do_loop(Statement& s, bool is_while) {
  bool yes = true;
  if (is_while && (!condition(s, yes) || !s.parser.take("DO"))) return s.ex.finished ? false : wrong(s);
  std::int64_t label = 0;
  if (!whole(s, label)) return false;
  if (label < 1 || label > kMostLabel) return wrong(s, Error::bad_argument);
  Level& here = level(s.ex);
  auto& loops = here.loops;
  for (std::size_t i = 0; i < loops.size(); ++i) {
    if (loops[i].offset == s.ex.at.byte_offset) {  // END n led back here
      loops.resize(i);
      break;
    }
    if (loops[i].label != label) continue;
    if (!loops[i].left_by_jump) return wrong(s, Error::bad_argument);  // a loop inside one of its own number
    loops.resize(i);
    break;
  }
  if (!yes) {
    here.skip_to_end = label;
    here.skip_from = s.ex.at;
    here.skip_from.column = s.column;
    return true;
  }
  loops.push_back({label, s.ex.at.byte_offset, s.ex.at.line, false});
  return true;
}

bool Language::do_end(Statement& s) {
  std::int64_t label = 0;
  if (!whole(s, label)) return false;
  auto& loops = level(s.ex).loops;
  while (!loops.empty() && loops.back().label != label) {
    if (!loops.back().left_by_jump) return wrong(s, Error::bad_argument);  // loops that cross
    loops.pop_back();
  }
  if (loops.empty()) return wrong(s, Error::bad_argument);  // a jump led into the loop
  if (!s.ex.count_jump()) return false;
  Frame& frame = s.ex.frames.back();
  loops.back().left_by_jump = false;
  if (!frame.reader->seek(loops.back().offset, loops.back().line))
    return s.ex.alarm(AlarmReason::sequence_not_found, s.column, "END " + std::to_string(label));
  frame.rest = nullptr;
  return true;
}

bool Language::message_text(Statement& s, std::string& text) {
  std::string piece;
  if (s.parser.string(piece)) {
    text += piece;
  } else {
    Value value;
    if (s.parser.error() != Error::none || !s.parser.expression(value)) return wrong(s);
    text += text_of(value);
  }
  if (text.size() > kMostText) text.resize(kMostText);
  return true;
}

bool Language::do_message(Statement& s) {
  if (!s.parser.take('[')) return wrong(s);
  std::string text;
  if (!s.parser.take(']')) {
    do {
      if (!message_text(s, text)) return false;
    } while (s.parser.take(','));
    if (!s.parser.take(']')) return wrong(s);
  }
  auto& message = s.ex.emit<interp::Message>();
  message.at = s.ex.at;
  message.text = text;
  return true;
}

// ERR[n, …]: alarm 3000+n (L20032).
bool Language::do_error(Statement& s) {
  if (!s.parser.take('[')) return wrong(s);
  std::int64_t number = 0;
  if (!whole(s, number)) return false;
  if (number < 0 || number >= 1'000) return wrong(s, Error::bad_argument);
  std::string text;
  while (s.parser.take(',')) {
    if (!message_text(s, text)) return false;
  }
  if (!s.parser.take(']')) return wrong(s);
  return raise(s.ex, "PS" + std::to_string(3'000 + number), s.column, text);
}

// Only handle 1, the serial port, works (L20060).
bool Language::do_handle(Statement& s, bool open) {
  std::int64_t handle = 0;
  if (!s.parser.take('[') || !whole(s, handle) || !s.parser.take(']'))
    return s.ex.finished ? false : wrong(s);
  if (handle != 1) return wrong(s, Error::bad_argument);
  write_open_ = open;
  return true;
}

bool Language::do_write(Statement& s) {
  std::int64_t handle = 0;
  if (!s.parser.take('[') || !whole(s, handle)) return s.ex.finished ? false : wrong(s);
  if (handle != 1 || !write_open_) return wrong(s, Error::bad_argument);
  std::string text;
  while (s.parser.take(',')) {
    if (!message_text(s, text)) return false;
  }
  if (!s.parser.take(']')) return wrong(s);
  return write_out(s.ex, std::move(text));
}

bool Language::do_call(Statement& s) {
  const std::uint32_t column = s.column;
  if (!s.parser.take('[')) return wrong(s);
  std::int64_t program = 0;
  if (!whole(s, program)) return false;
  std::vector<Argument> arguments;
  while (s.parser.take(',')) {
    if (arguments.size() == kMostArguments) return wrong(s, Error::bad_argument);
    Argument argument;
    const char* from = s.parser.position();
    Place place;
    if (s.parser.place(place) && place.count != 0) {
      for (std::uint32_t i = 0; i < place.count; ++i) {
        Value value;
        if (const Error error = read(place.number + i, value); error != Error::none) return wrong(s, error);
        argument.push_back(value);
      }
    } else {
      if (s.parser.error() != Error::none) return wrong(s);
      s.parser.set_position(from);
      Value value;
      if (!s.parser.value_or_null(value)) return wrong(s);
      argument.push_back(value);
    }
    arguments.push_back(std::move(argument));
  }
  if (!s.parser.take(']') || !s.parser.at_end()) return wrong(s);
  if (!call_macro(s.ex, program, 1, {}, column)) return false;
  level(s.ex).arguments = std::move(arguments);
  return true;
}

// PARAMS[r1, r5]: where the arguments of CALL go; what was not given stays NULL.
bool Language::do_params(Statement& s) {
  if (!s.parser.take('[')) return wrong(s);
  const auto& given = level(s.ex).arguments;
  std::size_t i = 0;
  do {
    Place place;
    if (i == kMostArguments) return wrong(s, Error::bad_argument);
    if (!s.parser.place(place)) return wrong(s);
    if (place.number >= k2000::kLocals) return wrong(s, Error::no_variable);
    const std::size_t size = place.count == 0 ? 1 : place.count;
    if (i < given.size()) {
      if (given[i].size() != size) return wrong(s, Error::array_size);
      for (std::size_t k = 0; k < size; ++k) {
        const Error error = write(place.number + static_cast<std::uint32_t>(k), given[i][k]);
        if (error != Error::none) return wrong(s, error);
      }
    }
    ++i;
  } while (s.parser.take(','));
  return s.parser.take(']') || wrong(s);
}

// ---- text of blocks

}  // namespace headstock::dialects::k2000tc
