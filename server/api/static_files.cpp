#include "server/api/static_files.hpp"

#include <nlohmann/json.hpp>

#ifdef HEADSTOCK_WEB_ASSETS
#include "web/assets.hpp"
#endif

namespace headstock::api {

namespace {

#ifdef HEADSTOCK_WEB_ASSETS

Reply asset_reply(const web::Asset& asset, const Request& request) {
  Reply reply;
  reply.cacheable = true;
  reply.content_type = std::string(asset.mime);
  reply.headers.emplace_back("ETag", std::string(asset.etag));
  reply.headers.emplace_back("Cache-Control", asset.immutable ? "public, max-age=31536000, immutable" : "no-cache");
  if (asset.gzip) reply.headers.emplace_back("Vary", "Accept-Encoding");
  if (request.headers.if_none_match.find(asset.etag) != std::string::npos) {
    reply.status = 304;
    return reply;
  }
  if (!asset.gzip) {
    reply.fixed = asset.bytes;
  } else if (request.headers.accept_encoding.find("gzip") != std::string::npos) {
    reply.fixed = asset.bytes;
    reply.headers.emplace_back("Content-Encoding", "gzip");
  } else {
    reply.body.resize(web::plain_size(asset));
    if (!web::unpack(asset, reply.body.data())) throw Refused("internal");
  }
  return reply;
}

const web::Asset* find(const Request& request) {
  if (const auto* asset = web::find(request.path)) return asset;
  // "/machines/3" is a page of the application; "/assets/x.js" that is not there is a mistake, not a page.
  const auto last = request.path.rfind('/');
  const bool file = last != std::string::npos && request.path.find('.', last) != std::string::npos;
  return file ? nullptr : web::find("/");
}

#else

constexpr std::string_view plain_page =
    "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><title>Headstock</title>"
    "<body><h1>Headstock</h1><p>The server runs, but the browser application was not built into it (HEADSTOCK_WEB).</p>"
    "<p lang=\"zh\">服务器正在运行，但未内置浏览器界面。</p>"
    "<p><a href=\"/api/v1/openapi.json\">/api/v1/openapi.json</a></p></body></html>";

#endif

}  // namespace

Reply static_file(const Request& request) {
#ifdef HEADSTOCK_WEB_ASSETS
  const auto* asset = find(request);
  if (!asset) throw Refused("not_found", request.path);
  return asset_reply(*asset, request);
#else
  if (request.path != "/") throw Refused("not_found", request.path);
  Reply reply;
  reply.content_type = "text/html; charset=utf-8";
  reply.fixed = plain_page;
  return reply;
#endif
}

}  // namespace headstock::api
