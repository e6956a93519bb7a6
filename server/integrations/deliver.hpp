// One message to one address: e-mail over SMTP, or a JSON document over HTTP (libcurl). Blocks for up to 20 seconds:
// worker threads only.
#pragma once

#include <string>

namespace headstock::integrations {

struct MailServer {
  std::string url;       ///< smtp://host:25, smtps://host:465; empty: none is set up
  std::string user, password;
  std::string from;
  bool demand_tls = false;  ///< STARTTLS or nothing; otherwise where the server offers it
};

struct Mail {
  std::string to, subject, text;  ///< UTF-8
};

/// The message as it goes over the wire: headers, encoded subject, base64 text. `at_ms`: its date.
std::string mail_text(const MailServer& server, const Mail& mail, std::int64_t at_ms, const std::string& id);
/// Words of an alarm message from its JSON body, Chinese and English. @param link address of the alarm page; may be empty.
Mail mail_of(const std::string& body, const std::string& to, const std::string& link);

/// @return empty when the server has taken it, otherwise why not.
std::string send_mail(const MailServer& server, const Mail& mail);
/// POSTs the body. With a secret: header X-Headstock-Signature: sha256=HEX, the HMAC of the body. Redirects are not
/// followed. @return empty for a 2xx answer, otherwise why not.
std::string call_webhook(const std::string& url, const std::string& body, const std::string& secret);

}  // namespace headstock::integrations
