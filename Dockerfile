# Three stages: the first has Node and builds the page, the second has the compiler, the third only the binary.
FROM node:22-bookworm-slim AS page
WORKDIR /build
COPY web/package.json web/package-lock.json web/.npmrc web/
RUN npm --prefix web ci --no-audit --no-fund
COPY web web
COPY examples/meshes examples/meshes
RUN npm --prefix web run build

FROM rust:1.95.0-slim-bookworm AS build
# SQLite is compiled from C source.
RUN apt-get update \
    && apt-get install --yes --no-install-recommends gcc libc6-dev \
    && rm -rf /var/lib/apt/lists/*
# The image has this toolchain; without this line rustup would fetch the components for development.
ENV RUSTUP_TOOLCHAIN=1.95.0
WORKDIR /build
COPY . .
COPY --from=page /build/web/dist/page web/dist/page
RUN cargo build --release --locked --bin graspd

FROM debian:bookworm-slim
RUN useradd --system --uid 10001 --home-dir /data --shell /usr/sbin/nologin graspd \
    && install --directory --owner=graspd --group=graspd --mode=0750 /data
COPY --from=build /build/target/release/graspd /usr/local/bin/graspd
USER graspd
VOLUME /data
EXPOSE 8080
ENV GRASPD_LISTEN=0.0.0.0:8080 GRASPD_DATA_DIR=/data GRASPD_AUTH=keys
# SIGTERM puts running jobs back into the queue; give it the time it may take.
STOPSIGNAL SIGTERM
ENTRYPOINT ["graspd"]
CMD ["serve"]
