#include "macro/names.hpp"

#include <charconv>

namespace headstock::macro {
namespace {

enum class For : std::uint8_t { both, lathe, mill };
struct Row {
  SystemName name;
  For series = For::both;
};

constexpr Row kNames[] = {
    {{"EMPTY", 0}},
    {{"UI", 1000, 32, 1, true}},
    {{"UIL", 1032, 4, 1, true}},
    {{"UO", 1100, 32, 1, true}},
    {{"UOL", 1132, 4, 1, true}},
    {{"OFS", 10001, 400}, For::mill},
    {{"OFSHW", 10001, 400}, For::mill},  // V10 = 1 exchanges geometry and wear: see system_variables.cpp
    {{"OFSHG", 11001, 400}, For::mill},
    {{"OFSDW", 12001, 400}, For::mill},
    {{"OFSDG", 13001, 400}, For::mill},
    {{"OFSX", 10001, 200}, For::lathe},
    {{"OFSZ", 11001, 200}, For::lathe},
    {{"OFSR", 12001, 200}, For::lathe},
    {{"OFST", 13001, 200}, For::lathe},
    {{"OFSY", 14001, 200}, For::lathe},
    {{"OFSXW", 10001, 200}, For::lathe},
    {{"OFSZW", 11001, 200}, For::lathe},
    {{"OFSRW", 12001, 200}, For::lathe},
    {{"OFSYW", 14001, 200}, For::lathe},
    {{"OFSYG", 19001, 200}, For::lathe},
    {{"OFSXG", 15001, 200}, For::lathe},
    {{"OFSZG", 16001, 200}, For::lathe},
    {{"OFSRG", 17001, 200}, For::lathe},
    {{"WKSFTX", 2501}, For::lathe},
    {{"WKSFTZ", 2601}, For::lathe},
    {{"ALM", 3000}},
    {{"CLOCK1", 3001}},
    {{"CLOCK2", 3002}},
    {{"CNTL1", 3003}},
    {{"M_SBK", 3003, 0, 1, false, 0}},
    {{"M_FIN", 3003, 0, 1, false, 1}},
    {{"CNTL2", 3004}},
    {{"M_FHD", 3004, 0, 1, false, 0}},
    {{"M_OV", 3004, 0, 1, false, 1}},
    {{"M_EST", 3004, 0, 1, false, 2}},
    {{"SETDT", 3005}},
    {{"MSGSTP", 3006}},
    {{"MRIMG", 3007}},
    {{"PRSTR", 3008}},
    {{"DATE", 3011}},
    {{"TIME", 3012}},
    {{"PI", 3101}},
    {{"E", 3102}},
    {{"PRTSA", 3901}},
    {{"PRTSN", 3902}},
    {{"OFSMEM", 3980}, For::mill},
    {{"MAINO", 4000}},
    {{"BUFG", 4001, 30}},
    {{"BUFB", 4102}, For::mill},
    {{"BUFD", 4107}, For::mill},
    {{"BUFE", 4108}},
    {{"BUFF", 4109}},
    {{"BUFH", 4111}, For::mill},
    {{"BUFM", 4113}},
    {{"BUFN", 4114}},
    {{"BUFO", 4115}},
    {{"BUFS", 4119}},
    {{"BUFT", 4120}},
    {{"BUFWZP", 4130}, For::mill},
    {{"ACTG", 4201, 30}},
    {{"ACTB", 4302}, For::mill},
    {{"ACTD", 4307}, For::mill},
    {{"ACTE", 4308}},
    {{"ACTF", 4309}},
    {{"ACTH", 4311}, For::mill},
    {{"ACTM", 4313}},
    {{"ACTN", 4314}},
    {{"ACTO", 4315}},
    {{"ACTS", 4319}},
    {{"ACTT", 4320}},
    {{"ACTWZP", 4330}, For::mill},
    {{"INTG", 4401, 30}},
    {{"INTB", 4502}, For::mill},
    {{"INTD", 4507}, For::mill},
    {{"INTE", 4508}},
    {{"INTF", 4509}},
    {{"INTH", 4511}, For::mill},
    {{"INTM", 4513}},
    {{"INTN", 4514}},
    {{"INTO", 4515}},
    {{"INTS", 4519}},
    {{"INTT", 4520}},
    {{"INTWZP", 4530}, For::mill},
    {{"ABSIO", 5001, 5}},
    {{"ABSMT", 5021, 5}},
    {{"ABSOT", 5041, 5}},
    {{"ABSKP", 5061, 5}},
    {{"TOFS", 5081, 5}},
    {{"TOFSWX", 5081}, For::lathe},
    {{"TOFSWZ", 5082}, For::lathe},
    {{"TOFSWY", 5083}, For::lathe},
    {{"SVERR", 5101, 5}},
    {{"TOFSGX", 5121}, For::lathe},
    {{"TOFSGZ", 5122}, For::lathe},
    {{"TOFSGY", 5123}, For::lathe},
    {{"TOFSG", 5121, 5}, For::lathe},
    {{"MIRTP", 5121, 5}},
    {{"DIST", 5181, 5}},
    {{"WZCMN", 5201, 5}},
    {{"WZG54", 5221, 5}},
    {{"WZG55", 5241, 5}},
    {{"WZG56", 5261, 5}},
    {{"WZG57", 5281, 5}},
    {{"WZG58", 5301, 5}},
    {{"WZG59", 5321, 5}},
};

}  // namespace

std::optional<SystemName> system_name(std::string_view name, bool lathe) {
  for (const Row& row : kNames) {
    if (row.name.name == name && row.series != (lathe ? For::mill : For::lathe)) return row.name;
  }
  if (name.starts_with("WZP") && !lathe) {
    unsigned p = 0;
    const char* end = name.data() + name.size();
    const auto [stop, error] = std::from_chars(name.data() + 3, end, p);
    if (error == std::errc() && stop == end && p >= 1 && p <= 48) return SystemName{name, 7001 + (p - 1) * 20, 5};
  }
  return std::nullopt;
}

}  // namespace headstock::macro
