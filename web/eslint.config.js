import eslint from "@eslint/js";
import tseslint from "typescript-eslint";

export default tseslint.config(
  { ignores: ["dist/**", "node_modules/**"] },
  eslint.configs.recommended,
  {
    files: ["**/*.ts"],
    extends: [tseslint.configs.strictTypeChecked],
    languageOptions: {
      parserOptions: { projectService: true, tsconfigRootDir: import.meta.dirname },
    },
    rules: {
      "@typescript-eslint/restrict-template-expressions": ["error", { allowNumber: true }],
    },
  },
  {
    files: ["tests/**/*.js", "types.js"],
    languageOptions: {
      globals: {
        process: "readonly",
        console: "readonly",
        Buffer: "readonly",
        URL: "readonly",
        document: "readonly",
        window: "readonly",
        navigator: "readonly",
        fetch: "readonly",
        setTimeout: "readonly",
        performance: "readonly",
        DataTransfer: "readonly",
        File: "readonly",
        DragEvent: "readonly",
        getComputedStyle: "readonly",
        HTMLCanvasElement: "readonly",
        Headers: "readonly",
        Blob: "readonly",
        DOMException: "readonly",
        DOMParser: "readonly",
        FormData: "readonly",
        Image: "readonly",
        atob: "readonly",
        requestAnimationFrame: "readonly",
      },
    },
  },
);
