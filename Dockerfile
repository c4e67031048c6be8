# barrelman, barrelman-guard and barrelman-media, from the packages that scripts/package.sh builds
# (docs/install.md).
#
#     docker build -t barrelman .
#
# BASE: a Debian of the packages' architecture, with their C library or a newer one.
ARG BASE=debian:bookworm-slim

FROM scratch AS packages
COPY target/debian/barrelman_*.deb target/debian/barrelman-media_*.deb /

FROM ${BASE}
# curl: the health check. procps: the entry point. systemd-standalone-sysusers: the package's user.
RUN --mount=type=bind,from=packages,target=/packages \
    apt-get update -qq && \
    DEBIAN_FRONTEND=noninteractive apt-get install -qq --no-install-recommends \
      curl procps systemd-standalone-sysusers /packages/*.deb && \
    rm -rf /var/lib/apt/lists/* && \
    install -d -o barrelman -g barrelman -m 750 /var/lib/barrelman
COPY config/container/entrypoint.sh /usr/local/bin/barrelman-entrypoint
USER barrelman
WORKDIR /var/lib/barrelman
VOLUME /var/lib/barrelman
# As systemd says it to the service: where the certificate authority stays.
ENV STATE_DIRECTORY=/var/lib/barrelman
EXPOSE 8480
# Of a console at port 8480: HTTPS on all addresses, HTTP on loopback.
HEALTHCHECK --interval=10s --timeout=5s --start-period=20s \
  CMD curl -fskm 2 https://127.0.0.1:8480/healthz || curl -fsm 2 http://127.0.0.1:8480/healthz || exit 1
ENTRYPOINT ["barrelman-entrypoint"]
CMD ["demo", "--listen", "0.0.0.0:8480"]
