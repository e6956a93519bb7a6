// `headstock convert-tape`: a program from one tape code to another, with the checks a control would make.
#include <fstream>
#include <iostream>

#include "offline/offline.hpp"
#include "protocol/process/options.hpp"
#include "protocol/tape/decoder.hpp"
#include "protocol/tape/encoder.hpp"

namespace headstock::offline {
namespace {

struct Options {
  std::string from = "iso", to = "ascii", end_of_block = "lf", symbols, out, file;
  std::vector<std::string> files;
  std::uint32_t leader = 0, trailer = 0;
  bool frame = false, tv = false, no_tv_comments = false, fold_case = false, back = false;
};

int fail(const std::string& text) {
  std::cerr << "headstock convert-tape: " << text << '\n';
  return 1;
}

void print(const tape::Findings& findings, const std::string& file) {
  for (const tape::Finding& finding : findings.kept())
    std::cerr << file << ": " << tape::describe(finding) << '\n';
  if (findings.count() > findings.kept().size())
    std::cerr << file << ": and " << findings.count() - findings.kept().size() << " more\n";
}

/// The file as an ISO tape, to the code and back: the same bytes, or it is said which character has no code.
enum class Back { identical, refused, different };
Back there_and_back(const Options& options, const std::string& text, tape::Finding& first) {
  tape::ReadFormat read;
  read.code = *tape::code_named(options.from);
  tape::PunchFormat iso, other;
  if (!other.symbols.read(options.symbols).empty()) return Back::refused;
  read.symbols = iso.symbols = other.symbols;
  iso.code = tape::Code::iso;
  other.code = *tape::code_named(options.to);
  iso.fold_case = options.fold_case;
  iso.end_of_block = other.end_of_block = tape::EndOfBlock::lf;
  tape::ReadFormat from_iso = read, from_other = read;
  from_iso.code = iso.code;
  from_other.code = other.code;
  tape::Findings read_findings, back_findings;
  const auto encode = [](const tape::PunchFormat& format, const std::string& what, tape::Findings& findings) {
    tape::Encoder encoder(format);
    std::string bytes;
    encoder.put(what, bytes);
    encoder.finish(bytes);
    findings = encoder.findings();
    return bytes;
  };
  tape::Findings to_iso, to_other, to_iso_again;
  const std::string tape_bytes = encode(iso, tape::decoded(text, read, &read_findings), to_iso);
  const std::string there = encode(other, tape::decoded(tape_bytes, from_iso), to_other);
  const std::string back = encode(iso, tape::decoded(there, from_other, &back_findings), to_iso_again);
  for (const auto* findings : {&read_findings, &to_iso, &to_other})
    if (!findings->none()) {
      first = findings->kept().front();
      return Back::refused;
    }
  return back == tape_bytes && back_findings.none() && to_iso_again.none() ? Back::identical
                                                                           : Back::different;
}

// @return 0 when every file that has its characters in both codes comes back as it was, 2 when one does not.
int check_back(const Options& options) {
  int identical = 0, refused = 0, different = 0;
  for (const auto& name : options.files) {
    std::ifstream in(name, std::ios::binary);
    if (!in) return fail(name + ": cannot be read");
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    tape::Finding first;
    switch (there_and_back(options, text, first)) {
      case Back::identical:
        ++identical;
        break;
      case Back::refused:
        ++refused;
        std::cerr << name << ": " << tape::describe(first) << '\n';
        break;
      case Back::different:
        ++different;
        std::cerr << name << ": comes back different\n";
        break;
    }
  }
  std::cout << identical << " identical, " << refused << " with a character that has no code, " << different
            << " different\n";
  return different == 0 ? 0 : 2;
}

// @return 0, 1 (cannot be read or written) or 2 (something could not be converted).
int convert(const Options& options) {
  tape::ReadFormat read;
  tape::PunchFormat punch;
  read.code = *tape::code_named(options.from);
  punch.code = *tape::code_named(options.to);
  if (const auto error = punch.symbols.read(options.symbols); !error.empty())
    return fail("--symbols: " + error);
  read.symbols = punch.symbols;
  punch.end_of_block = *tape::end_of_block_named(options.end_of_block);
  read.keep_cr = punch.end_of_block == tape::EndOfBlock::keep;
  read.tv_check = options.tv;
  read.tv_counts_comments = !options.no_tv_comments;
  punch.pad_for_tv = options.tv;
  punch.leader = options.leader;
  punch.trailer = options.trailer;
  punch.frame = options.frame;
  punch.fold_case = options.fold_case;

  std::ifstream file;
  if (options.file != "-") {
    file.open(options.file, std::ios::binary);
    if (!file) return fail(options.file + ": cannot be read");
  }
  std::ofstream out_file;
  if (!options.out.empty()) {
    out_file.open(options.out, std::ios::binary | std::ios::trunc);
    if (!out_file) return fail(options.out + ": cannot be written");
  }
  std::istream& in = options.file == "-" ? std::cin : file;
  std::ostream& out = options.out.empty() ? std::cout : out_file;
  tape::Decoder decoder(read);
  tape::Encoder encoder(punch);
  std::string piece(64u << 10, '\0'), text, bytes;
  const auto flush = [&] {
    encoder.put(text, bytes);
    out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    text.clear();
    bytes.clear();
  };
  while (in.read(piece.data(), static_cast<std::streamsize>(piece.size())), in.gcount() > 0) {
    decoder.put(std::string_view(piece).substr(0, static_cast<std::size_t>(in.gcount())), text);
    flush();
  }
  if (in.bad()) return fail(options.file + ": cannot be read");
  decoder.finish(text);
  flush();
  encoder.finish(bytes);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  out.flush();
  if (!out) return fail("cannot be written");
  print(decoder.findings(), options.file);
  print(encoder.findings(), options.file);
  return decoder.findings().none() && encoder.findings().none() ? 0 : 2;
}

}  // namespace

void add_convert_tape(options::Command app, int& exit_status) {
  const auto options = std::make_shared<Options>();
  auto command = app.add_command("convert-tape", "Convert a program between ISO, EIA and ASCII tape codes");
  const std::vector<std::string> codes = {"iso", "eia", "ascii"};
  command.option("--from", options->from, "iso, eia, ascii").required().one_of(codes);
  command.option("--to", options->to, "iso, eia, ascii").required().one_of(codes);
  command.option("--eob", options->end_of_block, "End of block: lf, crlf, lfcrcr, cr, keep")
      .shows_default()
      .one_of({"lf", "crlf", "lfcrcr", "cr", "keep"});
  command.option("--symbols", options->symbols,
                 "EIA holes of * = # [ ] ? @ & _ (parameters No.6010-6018), and of others, as #=4C,*=0D");
  command.option("--leader", options->leader, "Blank characters in front").between(0, 10'000);
  command.option("--trailer", options->trailer, "Blank characters behind").between(0, 10'000);
  command.flag("--frame", options->frame, "Put % lines around the program where they are missing");
  command.flag("--tv", options->tv,
               "Check the blocks read for an even number of characters, pad those written");
  command.flag("--tv-without-comments", options->no_tv_comments,
               "TV check does not count comments (No.0100#1)");
  command.flag("--fold-case", options->fold_case, "Lower-case letters become capitals");
  command.option("-o,--output", options->out, "File to write (standard output when left out)");
  command.flag("--there-and-back", options->back,
               "Only prove for each FILE that ISO, the other code and ISO again give the same bytes");
  command.option("FILE", options->files, "File to read, - for standard input").required();
  command.callback([options, &exit_status] {
    if (options->back) {
      exit_status = check_back(*options);
    } else if (options->files.size() != 1) {
      exit_status = fail("one FILE at a time");
    } else {
      options->file = options->files.front();
      exit_status = convert(*options);
    }
  });
}

}  // namespace headstock::offline
