// Messages: every field there and back; nothing else is taken from a peer.
#include "protocol/wire/messages.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "protocol/wire/digest.hpp"

namespace headstock::wire {
namespace {

using nlohmann::json;

const std::string kHash(64, 'a');

template <class M>
json fields_of(const M& message) {
  json value;
  EXPECT_EQ(decode_json(encode(message), value), "");
  return value;
}

/// Encodes, decodes, encodes: the same bytes.
template <class M>
void there_and_back(const M& message) {
  const std::string body = encode(message);
  M back;
  ASSERT_EQ(decode(body, back), "");
  EXPECT_EQ(encode(back), body);
  // Without any one of its fields it is no message, with one more it still is (a newer peer).
  const json whole = fields_of(message);
  for (const auto& [key, value] : whole.items()) {
    json part = whole;
    part.erase(key);
    EXPECT_EQ(decode(encode_json(part), back), key + ": missing");
    part[key] = json::object();
    EXPECT_NE(decode(encode_json(part), back), "") << key << " of another type";
  }
  json more = whole;
  more["of_a_newer_version"] = 1;
  EXPECT_EQ(decode(encode_json(more), back), "");
}

TEST(Messages, EveryOneThereAndBack) {
  Hello hello;
  hello.versions = {1, 2};
  hello.software = "headstock-agent 1";
  hello.name = "车床 1";
  hello.axes = {"X", "Z"};
  hello.census_hash = kHash;
  hello.machine_toml = "[machine]\n";
  hello.transfers = {5};
  there_and_back(hello);
  there_and_back(Welcome{1, 1'700'000'000'000, 3, 50});
  there_and_back(Refuse{"revoked", "why", {1}});
  there_and_back(Ping{1, -5});
  there_and_back(Enrol{"secret", "pem"});
  there_and_back(Enrolled{"pem", "ca", 3, "Lathe"});
  there_and_back(CertificateStored{"ab"});
  there_and_back(EventsAck{std::numeric_limits<std::uint64_t>::max()});
  there_and_back(Command{1, "cycle_start", "", 0.5, "li"});
  there_and_back(CommandResult{1, true, ""});
  there_and_back(TransferOpen{1, "O1", 5, kHash});
  there_and_back(ProgramGet{1, "O1"});
  there_and_back(Credit{1, 2, kHash, 3});
  there_and_back(DataEnd{1, kHash});
  there_and_back(TransferResult{1, true, 2, kHash, ""});
  there_and_back(TransferCancel{1, "stopped"});
}

TEST(Messages, BadValuesLeaveTheMessageAsItWas) {
  TransferOpen open{7, "old", 1, kHash};
  json value = fields_of(TransferOpen{1, "new", 5, kHash});
  value["sha256"] = "no hash";
  EXPECT_EQ(decode(encode_json(value), open), "sha256: not a SHA-256");
  EXPECT_EQ(open.name, "old");
  value["sha256"] = kHash;
  for (const json& bytes : {json(-1), json(1.5), json("5"), json(nullptr), json(true)}) {
    value["bytes"] = bytes;
    EXPECT_NE(decode(encode_json(value), open), "") << bytes;
  }
  value["bytes"] = 5;
  value["name"] = std::string(257, 'x');
  EXPECT_EQ(decode(encode_json(value), open), "name: too long");
  value["name"] = std::string("a\0b", 3);
  EXPECT_EQ(decode(encode_json(value), open), "name: has a NUL");
}

TEST(Messages, NumbersThatAreNone) {
  Command command;
  json value = fields_of(Command{1, "set_feed_override", "", 1, ""});
  value["value"] = std::numeric_limits<double>::infinity();
  EXPECT_NE(decode(encode_json(value), command), "");
  value["value"] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(decode(encode_json(value), command), "");
  Ping ping;
  value = fields_of(Ping{});
  value["time_ms"] = std::numeric_limits<std::uint64_t>::max();
  EXPECT_NE(decode(encode_json(value), ping), "") << "beyond a signed number";
}

TEST(Messages, ListsAreBounded) {
  Refuse refuse;
  json value = fields_of(Refuse{"a", "b", {1}});
  value["versions"] = json(std::vector<int>(65, 1));
  EXPECT_EQ(decode(encode_json(value), refuse), "versions: too long");
}

std::string why(const std::string& bytes) {
  json value;
  return decode_json(bytes, value);
}

TEST(Cbor, OnlyTheStrictSubset) {
  EXPECT_EQ(why("\xa0"), "");
  EXPECT_EQ(why(std::string("\xa1\x61\x61\x00", 4)), "");
  EXPECT_EQ(why(""), "cut short");
  EXPECT_EQ(why(std::string("\xa0\x00", 2)), "bytes after the message");
  EXPECT_EQ(why("\x9f\xff"), "a length of unknown form");
  EXPECT_EQ(why("\xbf\xff"), "a length of unknown form");
  EXPECT_EQ(why("\x41x"), "a value of unknown kind") << "byte string";
  EXPECT_EQ(why(std::string("\xc0\x00", 2)), "a value of unknown kind") << "tag";
  EXPECT_EQ(why("\xf7"), "a value of unknown kind") << "undefined";
  EXPECT_EQ(why(std::string("\xa1\x00\x00", 3)), "a key that is no text");
  EXPECT_EQ(why("\x62\xc3\x28"), "a text that is not UTF-8");
  EXPECT_EQ(why("\x63\xed\xa0\x80"), "a text that is not UTF-8") << "surrogate";
  EXPECT_EQ(why("\x62\xc0\x80"), "a text that is not UTF-8") << "overlong";
}

TEST(Cbor, LyingLengthsCostNothing) {
  EXPECT_EQ(why(std::string("\x9b\x7f\xff\xff\xff\xff\xff\xff\xff", 9)), "cut short");
  EXPECT_EQ(why(std::string("\xbb\xff\xff\xff\xff\xff\xff\xff\xff", 9)), "cut short");
  EXPECT_EQ(why(std::string("\x7b\xff\xff\xff\xff\xff\xff\xff\xff", 9)), "cut short");
}

TEST(Cbor, DepthAndCountAreBounded) {
  EXPECT_EQ(why(std::string(1'000'000, '\x81')), "nested too deep");
  std::string many("\x9a\x00\x04\x00\x00", 5);  // 262,144 items
  many += std::string(262'144, '\0');
  EXPECT_EQ(why(many), "too many items");
}

TEST(Sha256, GrowsAndIsCopied) {
  Sha256 digest;
  EXPECT_EQ(digest.hex(), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  digest.update("ab");
  const Sha256 copy = digest;
  digest.update("c");
  EXPECT_EQ(digest.hex(), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(copy.hex(), sha256_hex("ab"));
}

}  // namespace
}  // namespace headstock::wire
