#include "protocol/wire/messages.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "protocol/wire/cbor_check.hpp"
#include "protocol/wire/digest.hpp"

namespace headstock::wire {
namespace {

using nlohmann::json;

// Bounds of texts [bytes].
constexpr std::size_t kWord = 64, kName = 256, kSentence = 1024, kDocument = 64u << 10;
constexpr std::size_t kListLength = 64;

/// How a field is checked beyond its type.
enum class Form { free, hash };

struct Writer {
  json& object;
  template <class T>
  void operator()(const char* key, const T& value, std::size_t = 0, Form = Form::free) {
    object[key] = value;
  }
};

struct Reader {
  const json& object;
  std::string wrong;

  void fail(const char* key, const char* what) {
    if (wrong.empty()) wrong = std::string(key) + ": " + what;
  }
  const json* find(const char* key) {
    const auto found = object.find(key);
    if (found == object.end()) fail(key, "missing");
    return found == object.end() ? nullptr : &*found;
  }
  bool text(const char* key, const json& value, std::string& into, std::size_t limit) {
    const auto* bytes = value.get_ptr<const json::string_t*>();
    if (!bytes)
      fail(key, "not a text");
    else if (bytes->size() > limit)
      fail(key, "too long");
    else if (bytes->find('\0') != std::string::npos)
      fail(key, "has a NUL");
    else
      into = *bytes;
    return wrong.empty();
  }
  bool number(const char* key, const json& value, std::uint64_t& into) {
    if (value.is_number_unsigned())
      into = value.get<std::uint64_t>();
    else
      fail(key, "not a whole number from 0");
    return wrong.empty();
  }

  void operator()(const char* key, std::string& into, std::size_t limit, Form form = Form::free) {
    const json* value = find(key);
    if (!value || !text(key, *value, into, limit)) return;
    if (form == Form::hash && !is_sha256_hex(into)) fail(key, "not a SHA-256");
  }
  void operator()(const char* key, std::uint64_t& into) {
    if (const json* value = find(key)) number(key, *value, into);
  }
  void operator()(const char* key, std::int64_t& into) {
    const json* value = find(key);
    if (!value) return;
    if (!value->is_number_integer() ||
        (value->is_number_unsigned() && value->get<std::uint64_t>() > static_cast<std::uint64_t>(INT64_MAX)))
      return fail(key, "not a whole number");
    into = value->get<std::int64_t>();
  }
  void operator()(const char* key, bool& into) {
    const json* value = find(key);
    if (!value) return;
    if (!value->is_boolean()) return fail(key, "not true or false");
    into = value->get<bool>();
  }
  void operator()(const char* key, double& into) {
    const json* value = find(key);
    if (!value) return;
    if (!value->is_number() || !std::isfinite(value->get<double>())) return fail(key, "not a number");
    into = value->get<double>();
  }
  template <class T>
  void operator()(const char* key, std::vector<T>& into, std::size_t limit = 0) {
    const json* value = find(key);
    if (!value) return;
    if (!value->is_array()) return fail(key, "not a list");
    if (value->size() > kListLength) return fail(key, "too long");
    into.clear();
    for (const json& item : *value) {
      T one{};
      if constexpr (std::is_same_v<T, std::string>) {
        if (!text(key, item, one, limit)) return;
      } else {
        if (!number(key, item, one)) return;
      }
      into.push_back(std::move(one));
    }
  }
};

// The fields of each message, said once for both directions. `M` is the message, const when writing.
template <class V, class M>
requires std::is_same_v<std::remove_const_t<M>, Hello>
void fields(V& v, M& m) {
  v("versions", m.versions);
  v("software", m.software, kName);
  v("name", m.name, kName);
  v("profile", m.profile, kWord);
  v("axes", m.axes, 8);
  v("boot_id", m.boot_id, kWord);
  v("spool_id", m.spool_id, kWord);
  v("acknowledged", m.acknowledged);
  v("memory_bytes", m.memory_bytes);
  v("census_hash", m.census_hash, kWord, Form::hash);
  v("machine_toml", m.machine_toml, kDocument);
  v("transfers", m.transfers);
}
template <class V, class M>
requires std::is_same_v<std::remove_const_t<M>, Welcome>
void fields(V& v, M& m) {
  v("version", m.version);
  v("server_time_ms", m.server_time_ms);
  v("machine", m.machine);
  v("parts_required", m.parts_required);
}
template <class V, class M>
requires std::is_same_v<std::remove_const_t<M>, Refuse>
void fields(V& v, M& m) {
  v("reason", m.reason, kWord);
  v("text", m.text, kSentence);
  v("versions", m.versions);
}
template <class V, class M>
requires std::is_same_v<std::remove_const_t<M>, Ping>
void fields(V& v, M& m) {
  v("sequence", m.sequence);
  v("time_ms", m.time_ms);
}
template <class V, class M>
requires std::is_same_v<std::remove_const_t<M>, Enrol>
void fields(V& v, M& m) {
  v("token", m.token, kName);
  v("request_pem", m.request_pem, 8u << 10);
}
template <class V, class M>
requires std::is_same_v<std::remove_const_t<M>, Enrolled>
void fields(V& v, M& m) {
  v("certificate_pem", m.certificate_pem, 16u << 10);
  v("ca_pem", m.ca_pem, 16u << 10);
  v("machine", m.machine);
  v("machine_name", m.machine_name, kName);
}
template <class V, class M>
requires std::is_same_v<std::remove_const_t<M>, CertificateStored>
void fields(V& v, M& m) {
  v("serial", m.serial, kWord);
}
template <class V, class M>
requires std::is_same_v<std::remove_const_t<M>, EventsAck>
void fields(V& v, M& m) {
  v("sequence", m.sequence);
}
template <class V, class M>
requires std::is_same_v<std::remove_const_t<M>, Command>
void fields(V& v, M& m) {
  v("id", m.id);
  v("action", m.action, kWord);
  v("name", m.name, kName);
  v("value", m.value);
  v("user", m.user, kName);
}
template <class V, class M>
requires std::is_same_v<std::remove_const_t<M>, CommandResult>
void fields(V& v, M& m) {
  v("id", m.id);
  v("accepted", m.accepted);
  v("reason", m.reason, kSentence);
}
template <class V, class M>
requires std::is_same_v<std::remove_const_t<M>, TransferOpen>
void fields(V& v, M& m) {
  v("transfer", m.transfer);
  v("name", m.name, kName);
  v("bytes", m.bytes);
  v("sha256", m.sha256, kWord, Form::hash);
}
template <class V, class M>
requires std::is_same_v<std::remove_const_t<M>, ProgramGet>
void fields(V& v, M& m) {
  v("transfer", m.transfer);
  v("name", m.name, kName);
}
template <class V, class M>
requires std::is_same_v<std::remove_const_t<M>, Credit>
void fields(V& v, M& m) {
  v("transfer", m.transfer);
  v("offset", m.offset);
  v("sha256", m.sha256, kWord, Form::hash);
  v("granted", m.granted);
}
template <class V, class M>
requires std::is_same_v<std::remove_const_t<M>, DataEnd>
void fields(V& v, M& m) {
  v("bytes", m.bytes);
  v("sha256", m.sha256, kWord, Form::hash);
}
template <class V, class M>
requires std::is_same_v<std::remove_const_t<M>, TransferResult>
void fields(V& v, M& m) {
  v("transfer", m.transfer);
  v("ok", m.ok);
  v("bytes", m.bytes);
  v("sha256", m.sha256, kWord);
  v("reason", m.reason, kSentence);
}
template <class V, class M>
requires std::is_same_v<std::remove_const_t<M>, TransferCancel>
void fields(V& v, M& m) {
  v("transfer", m.transfer);
  v("reason", m.reason, kSentence);
}

}  // namespace

std::string encode_json(const json& value) {
  std::string body;
  json::to_cbor(value, nlohmann::detail::output_adapter<char>(body));
  return body;
}

std::string decode_json(std::string_view body, json& value) {
  if (std::string wrong = check_cbor(body); !wrong.empty()) return wrong;
  try {
    value = json::from_cbor(body.begin(), body.end(), true, false);
  } catch (const json::exception&) {
    return "not CBOR";
  }
  return value.is_discarded() ? "not CBOR" : "";
}

template <class Message>
std::string encode(const Message& message) {
  json object = json::object();
  Writer writer{object};
  fields(writer, message);
  return encode_json(object);
}

template <class Message>
std::string decode(std::string_view body, Message& message) {
  json object;
  if (std::string wrong = decode_json(body, object); !wrong.empty()) return wrong;
  if (!object.is_object()) return "not a map";
  Message read;
  Reader reader{object, {}};
  fields(reader, read);
  if (reader.wrong.empty()) message = std::move(read);
  return reader.wrong;
}

#define HEADSTOCK_MESSAGE(M)                \
  template std::string encode<M>(const M&); \
  template std::string decode<M>(std::string_view, M&)
HEADSTOCK_MESSAGE(Hello);
HEADSTOCK_MESSAGE(Welcome);
HEADSTOCK_MESSAGE(Refuse);
HEADSTOCK_MESSAGE(Ping);
HEADSTOCK_MESSAGE(Enrol);
HEADSTOCK_MESSAGE(Enrolled);
HEADSTOCK_MESSAGE(CertificateStored);
HEADSTOCK_MESSAGE(EventsAck);
HEADSTOCK_MESSAGE(Command);
HEADSTOCK_MESSAGE(CommandResult);
HEADSTOCK_MESSAGE(TransferOpen);
HEADSTOCK_MESSAGE(ProgramGet);
HEADSTOCK_MESSAGE(Credit);
HEADSTOCK_MESSAGE(DataEnd);
HEADSTOCK_MESSAGE(TransferResult);
HEADSTOCK_MESSAGE(TransferCancel);
#undef HEADSTOCK_MESSAGE

}  // namespace headstock::wire
